"""placeholder until the thesis kernels land"""


class ThesisRun:  # noqa
    def __init__(self, *a):
        raise NotImplementedError
