"""The studio's campaigns: started, watched, stopped and resumed, each in its own process.

The modules are imported one by one, because watching a campaign needs none of the code that begins
one.
"""
