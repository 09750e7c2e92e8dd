"""What pip calls to build ldbench: meson-python, whose editable installations would need the build folder of pip at each import."""
from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import ZipFile

from mesonpy import build_sdist, build_wheel, get_requires_for_build_sdist, get_requires_for_build_wheel

__all__ = ["build_editable", "build_sdist", "build_wheel", "get_requires_for_build_editable", "get_requires_for_build_sdist",
           "get_requires_for_build_wheel"]
WRAPPERS = Path(__file__).parent

get_requires_for_build_editable = get_requires_for_build_wheel


def build_editable(wheel_directory: str, config_settings: dict[str, Any] | None = None,
                   metadata_directory: str | None = None) -> str:
    """For `pip install -e .`: build once, put what is compiled beside the sources, and hand pip the path to the sources."""
    with TemporaryDirectory() as folder:
        name = build_wheel(folder, config_settings)
        with ZipFile(Path(folder, name)) as whole, ZipFile(Path(wheel_directory, name), "w") as editable:
            record = ["ldbench.pth,,"]
            for member in whole.infolist():
                folder_of, _, file = member.filename.rpartition("/")
                if folder_of.endswith(".dist-info") and file != "RECORD":
                    editable.writestr(member, whole.read(member))
                    record.append(f"{member.filename},,")
                elif folder_of == "ldbench/_core" and not file.endswith((".py", ".pyi")):
                    whole.extract(member, WRAPPERS)
                    (WRAPPERS/member.filename).chmod(0o755)
                elif file == "RECORD":
                    place = member.filename
            editable.writestr("ldbench.pth", f"{WRAPPERS}\n")
            editable.writestr(place, "\n".join([*record, f"{place},,"]) + "\n")
    return name
