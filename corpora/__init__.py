"""corpora.

PYTEST_DONT_REWRITE: a program that has imported this may call pytest.main() without a warning.
"""
