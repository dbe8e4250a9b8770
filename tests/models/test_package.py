"""The models are found in every kind of installation."""

from __future__ import annotations

import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

import pytest
from drake_ltl.models import PACKAGE_NAME, package_xml
from pydrake.multibody.parsing import PackageMap

REPOSITORY = Path(__file__).parents[2]


def test_package_xml_names_the_package():
    packages = PackageMap.MakeEmpty()
    packages.AddPackageXml(str(package_xml()))
    assert packages.GetPackageNames() == [PACKAGE_NAME]
    assert Path(packages.GetPath(PACKAGE_NAME)).samefile(package_xml().parent)


@pytest.mark.parametrize("uri", ["agents/planar_arm.urdf", "bases/differential_drive.urdf", "objects/crate.sdf"])
def test_uris_resolve(uri):
    packages = PackageMap.MakeEmpty()
    packages.AddPackageXml(str(package_xml()))
    assert Path(packages.ResolveUrl(f"package://{PACKAGE_NAME}/{uri}")).is_file()


def test_does_not_import_drake():
    code = "import sys, drake_ltl.models as m; m.package_xml(); sys.exit('pydrake' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_file_is_package_data():
    """setuptools installs only what is listed; a forgotten glob would show in wheels alone."""
    tomllib = pytest.importorskip("tomllib", reason="tomllib is part of Python from 3.11 on")
    with (REPOSITORY / "pyproject.toml").open("rb") as file:
        globs = tomllib.load(file)["tool"]["setuptools"]["package-data"]["drake_ltl.models"]
    models = REPOSITORY / "models"
    files = [p.relative_to(models) for p in models.rglob("*") if p.is_file() and p.suffix not in {".py", ".pyc"}]
    assert files
    for file in files:
        # a * of setuptools does not cross folders, fnmatch's does
        assert any(len(Path(g).parts) == len(file.parts) and fnmatch(str(file), g) for g in globs), file
