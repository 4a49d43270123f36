"""Sets of worlds: many of one family, with a manifest from which they are made again byte for byte.

Contents:
    plan_set, plan_wanted_set, plan_stratified_set: what a set is to hold.
    make_set: a folder or an archive with a manifest; what is interrupted goes on.
    manifest_of, regenerate_set, restore_set: the same set again from its manifest.
    strata_of: how its worlds are spread over strata of difficulty.
    check_set: compares a set with its manifest.
    ManifestHeader, ManifestEntry, Manifest: what the manifest says.

``docs/howto/sets.md`` tells what a user sees.
"""

from worldgen.sets.check import SetDifference, check_set, manifest_of
from worldgen.sets.make import SetDiffers, SetDone, begun_set, make_set, regenerate_set, restore_set
from worldgen.sets.manifest import MANIFEST, Manifest, ManifestEntry, ManifestHeader
from worldgen.sets.plan import SeededPlan, SetPlan, plan_set
from worldgen.sets.stratified import StratifiedPlan, StratumCount, plan_stratified_set, strata_of
from worldgen.sets.wanted import WantedPlan, plan_wanted_set

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
    "StratifiedPlan",
    "StratumCount",
    "WantedPlan",
    "begun_set",
    "check_set",
    "make_set",
    "manifest_of",
    "plan_set",
    "plan_stratified_set",
    "plan_wanted_set",
    "regenerate_set",
    "restore_set",
    "strata_of",
]
