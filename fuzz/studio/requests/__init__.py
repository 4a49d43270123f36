"""What a request of the page can contain, name, open and run, and how it is refused."""
