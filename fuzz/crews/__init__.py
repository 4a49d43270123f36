"""Who does a campaign's work: this process, others on this machine, or a Dask cluster's workers.

Contents:
    Crew: what a campaign asks of them.
    Alone, Processes, crew_of: here, and on this machine. fuzz.crews.cluster has Cluster.
    WorkersLost: raised if they end before the work does.
"""

from fuzz.crews.crew import Crew, WorkersLost
from fuzz.crews.local import Alone, Processes, crew_of

__all__ = ["Alone", "Crew", "Processes", "WorkersLost", "crew_of"]
