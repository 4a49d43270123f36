"""The warehouse keeps what every family promises."""

from warehouse_worlds import warehouse

from worldgen.family import FAMILIES
from worldgen.testing import check_family

# Printed by `worldgen check-family warehouse --digests`; when one changes, raise the family's
# version.
GOLDEN = {"aisles": "7bb8fcbb6638de43", "fishbone": "1867c6a026451d06"}


def test_the_warehouse_keeps_every_promise():
    check_family(warehouse, golden=GOLDEN)


def test_the_installed_package_registers_it():
    assert FAMILIES.get("warehouse").build is warehouse.build
