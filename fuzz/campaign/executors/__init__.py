"""Executors of a campaign's work: this process, others on this machine, or a Dask cluster.

Contents:
    Executor: the interface.
    InlineExecutor, ProcessExecutor, local_executor: in this process, and on this machine.
    cluster_executor: on a cluster.
    WorkersLost: raised if workers end before the work does.
"""

from fuzz.campaign.executors.executor import Executor, WorkersLost
from fuzz.campaign.executors.local import InlineExecutor, ProcessExecutor, local_executor
from fuzz.unit.config import CampaignConfig
from worldgen.errors import InvalidParameter
from worldgen.plugins.installation import pip_install

__all__ = [
    "Executor",
    "InlineExecutor",
    "ProcessExecutor",
    "WorkersLost",
    "cluster_executor",
    "local_executor",
]


def cluster_executor(address: str, config: CampaignConfig) -> Executor:
    """Return an executor for the Dask cluster with this scheduler.

    Raises:
        InvalidParameter: If the extra ``[dask]`` isn't installed, or a file of the configuration
            cannot be read.
    """
    try:
        from fuzz.campaign.executors.dask import DaskExecutor
    except ModuleNotFoundError as error:
        if error.name not in ("dask", "distributed"):
            raise
        raise InvalidParameter(
            "package-missing",
            "{option} needs Dask",
            "{install}, or omit it",
            at_terminal=True,
            option="--scheduler",
            install=pip_install("dask"),
        ) from error
    return DaskExecutor(address, config)
