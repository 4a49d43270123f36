"""A studio's folder with the same failures as files and in archives, and a finished campaign of
behaviours.
"""

import contextlib
import io
import shutil
import tarfile
import zipfile
from pathlib import Path

from tests.helpers.studio import page_of, studio_of
from tests.helpers.studio_campaign import begin, watch

FAILURES = sorted((Path(__file__).parents[2] / "corpora/failures/turn-right/swept").glob("*.grid"))[
    :4
]


def pack_zip(place, files):
    with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)


def pack_tar(place, files):
    with tarfile.open(place, "w:gz") as archive:
        for name, data in files.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))


def pack_dotted_tar(place, files):
    """Named as by ``tar czf set.tgz .``."""
    pack_tar(place, {f"./{name}": data for name, data in files.items()})


PACKERS = {"old.zip": pack_zip, "below/old.tar.gz": pack_tar, "below/whole.tgz": pack_dotted_tar}


def fill(folder):
    """Put the failures into ``plain`` and into each archive."""
    (folder / "below").mkdir()
    (folder / "plain").mkdir()
    for file in FAILURES:
        shutil.copy(file, folder / "plain")
    for name, pack in PACKERS.items():
        pack(
            folder / name,
            {f"deep/{file.name}": file.read_bytes() for file in FAILURES} | {"notes.txt": b"mine"},
        )


@contextlib.contextmanager
def studio_with_kinds(folder):
    """Serve a folder, and run the campaign ``kinds`` of the strategy of behaviours in it first."""
    with studio_of(folder) as gate:
        with page_of(gate) as page:
            assert "answer" in begin(page, "kinds", strategies=["archive"], units=2)
            watch(page, "kinds")
        yield gate
