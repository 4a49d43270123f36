"""``import worldgen.gym`` registers the environment ``worldgen/Navigate-v0`` with Gymnasium.

It names the environments as texts, which Gymnasium imports when one is made. Since its version 1
Gymnasium looks for no entry points; but ``gymnasium.make("worldgen.gym:worldgen/Navigate-v0")``
imports this by itself.
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
TIME_LIMIT = 1000  # steps of an episode, unless make() is told otherwise

if ENVIRONMENT not in gymnasium.registry:
    gymnasium.register(
        id=ENVIRONMENT,
        entry_point="worldgen_plugins.for_gymnasium:NavigateEnv",
        vector_entry_point="worldgen_plugins.for_gymnasium:NavigateVectorEnv",
        max_episode_steps=TIME_LIMIT,
    )
