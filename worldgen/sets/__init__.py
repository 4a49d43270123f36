"""Sets of worlds: many of one family, with a manifest that reproduces them byte for byte.

Contents:
    plan_set, plan_wanted_set: plan the contents of a set.
    make_set: make a folder or an archive with a manifest; an interrupted set is continued.
    manifest_of, regenerate_set, restore_set: rebuild the same set from its manifest.
    strata_of: the distribution of its worlds over strata of difficulty.
    check_set: compare a set with its manifest.
    ManifestHeader, ManifestEntry, Manifest: the contents of a manifest.

``docs/howto/sets.md`` describes them for users.
"""

from worldgen.sets.check import SetDifference, check_set, manifest_of
from worldgen.sets.make import SetDiffers, SetDone, begun_set, make_set, regenerate_set, restore_set
from worldgen.sets.manifest import MANIFEST, Manifest, ManifestEntry, ManifestHeader
from worldgen.sets.plan import SeededPlan, SetPlan, plan_set
from worldgen.sets.searched import StratumCount, WantedPlan, plan_wanted_set, strata_of

__all__ = [
    "MANIFEST",
    "Manifest",
    "ManifestEntry",
    "ManifestHeader",
    "SeededPlan",
    "SetDifference",
    "SetDiffers",
    "SetDone",
    "SetPlan",
    "StratumCount",
    "WantedPlan",
    "begun_set",
    "check_set",
    "make_set",
    "manifest_of",
    "plan_set",
    "plan_wanted_set",
    "regenerate_set",
    "restore_set",
    "strata_of",
]
