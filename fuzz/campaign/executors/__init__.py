"""Who does a campaign's work: this process, others on this machine, or a Dask cluster's workers.

Contents:
    Crew: what a campaign asks of them.
    Alone, Processes, crew_of: here, and on this machine.
    crew_at: a cluster's.
    WorkersLost: raised if they end before the work does.
"""

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.executors.executor import Crew, WorkersLost
from fuzz.campaign.executors.local import Alone, Processes, crew_of
from worldgen.errors import InvalidParameter
from worldgen.plugins.installation import pip_install

__all__ = ["Alone", "Crew", "Processes", "WorkersLost", "crew_at", "crew_of"]


def crew_at(address: str, config: CampaignConfig) -> Crew:
    """The workers of the Dask cluster with this scheduler.

    Raises:
        InvalidParameter: If the extra ``[dask]`` is not installed, or a file of the configuration cannot be read.
    """
    try:
        from fuzz.campaign.executors.dask import Cluster
    except ModuleNotFoundError as error:
        if error.name not in ("dask", "distributed"):
            raise
        raise InvalidParameter(
            "package-missing",
            "{option} needs Dask",
            "{install}, or leave it out",
            at_terminal=True,
            option="--scheduler",
            install=pip_install("dask"),
        ) from error
    return Cluster(address, config)
