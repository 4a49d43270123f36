"""``import worldgen.gym`` registers the environment ``worldgen/Navigate-v0`` with Gymnasium.

The environments are registered as import paths, which Gymnasium imports when one is made. Since
version 1 Gymnasium ignores entry points; but
``gymnasium.make("worldgen.gym:worldgen/Navigate-v0")`` imports this module automatically.
"""

from __future__ import annotations

try:
    import gymnasium
except ModuleNotFoundError as error:
    if error.name != "gymnasium":
        raise
    from worldgen.plugins.installation import pip_install

    raise ModuleNotFoundError(
        f"worldgen.gym needs Gymnasium, which is not installed; {pip_install('gym')}",
        name="gymnasium",
    ) from None

__all__ = ["ENVIRONMENT", "TIME_LIMIT"]

ENVIRONMENT = "worldgen/Navigate-v0"
# Steps of an episode, unless make() overrides it.
TIME_LIMIT = 1000

if ENVIRONMENT not in gymnasium.registry:
    gymnasium.register(
        id=ENVIRONMENT,
        entry_point="worldgen_plugins.for_gymnasium:NavigateEnv",
        vector_entry_point="worldgen_plugins.for_gymnasium:NavigateVectorEnv",
        max_episode_steps=TIME_LIMIT,
    )
