"""What other programs load.

Light, for pytest and Hypothesis load it in every project of an environment. Contents:
    for_pytest: worlds as test parameters, stored failures as tests, failure sections.
    for_hypothesis: ``World`` for ``st.from_type``.
    for_gymnasium: environments for reinforcement learning, which ``worldgen.gym`` registers.

All stand outside ``fuzz`` so that a project with a folder of that name, which hides the package,
still starts.

PYTEST_DONT_REWRITE: a program that has imported this may call pytest.main() without a warning.
"""
