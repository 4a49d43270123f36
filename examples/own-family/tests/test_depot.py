"""The depot keeps what every family promises."""

from depot_worlds import depot

from worldgen.family import FAMILIES
from worldgen.testing import check_family

# Printed by `worldgen check-family depot --digests`; when one changes, raise the family's
# version.
GOLDEN = {"aisles": "f64454c6c2552939", "fishbone": "f5306a070e3c136c"}


def test_the_depot_keeps_every_promise():
    check_family(depot, golden=GOLDEN)


def test_the_installed_package_registers_it():
    assert FAMILIES.get("depot").build is depot.build
