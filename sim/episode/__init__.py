"""Episodes: run a controller in a world, and see what happened.

Contents:
    simulate: Runs one controller in one world.
    Episode: What happened in the run.
    episode_of: Returns the episode of an outcome that needs no proof.
    prepare: Packs a world, a controller and options for their motion model.
    area_of: Computes the area of the cells that a robot visited.
    wall_evidence: Returns the facts about a robot that went into a wall.
"""

from sim.episode.run import Episode, area_of, episode_of, prepare, simulate, wall_evidence

__all__ = ["Episode", "area_of", "episode_of", "prepare", "simulate", "wall_evidence"]
