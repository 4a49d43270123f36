"""What a search draws: the bytes of a layout, the varied values, and the worlds made from them."""
