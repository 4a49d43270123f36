"""All answers: each kind of request is answered by the function registered for it."""

from fuzz.studio import catalogue, comparing, exchange, gallery, runs, worlds
from fuzz.studio.campaigns import answers as campaigns
from fuzz.studio.requests.folder import answer

ANSWERING = (campaigns, catalogue, comparing, exchange, gallery, runs, worlds)
"""The modules that answer; importing them registers their functions."""

__all__ = ["ANSWERING", "answer"]
