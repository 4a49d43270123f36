"""Plug-ins that other programs load.

They are small, because pytest and Hypothesis load them in every project of an environment.

Contents:
    for_pytest: Worlds as test parameters, stored failures as tests, and a section in reports.
    for_hypothesis: ``World`` for ``st.from_type``.
    for_gymnasium: Environments for reinforcement learning, registered by ``worldgen.gym``.

The plug-ins are not part of ``fuzz``, because a project with a folder of that name hides the
package, and must still start.

PYTEST_DONT_REWRITE: lets a program that has imported this call pytest.main() without a warning.
"""
