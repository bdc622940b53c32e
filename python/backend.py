"""Builds the wheel for `pip install .`: CMake compiles, in build/release, and this packs what comes out, with the helper
programs that meshes and STEP files take.

A build backend as PEP 517 has them, without any package from elsewhere."""
import base64
import hashlib
import os
import pathlib
import subprocess
import sysconfig
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PACKAGE = ROOT / "build/release/python/kinetostat"
HELPERS = [ROOT / "build/release" / f"kinetostat-{name}" for name in ("tetgen", "cgal", "step")]
NAME = f"{PROJECT['name']}-{PROJECT['version']}"


def _tag():
    python = "cp" + sysconfig.get_config_var("py_version_nodot")
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{python}-{python}-{platform}"


def _run(*command):
    subprocess.run(command, cwd=ROOT, check=True)


def _metadata():
    return "\n".join([
        "Metadata-Version: 2.1", f"Name: {PROJECT['name']}", f"Version: {PROJECT['version']}", f"Summary: {PROJECT['description']}",
        f"License: {PROJECT['license']['text']}", f"Requires-Python: {PROJECT['requires-python']}",
        *(f"Requires-Dist: {one}" for one in PROJECT["dependencies"]), "Description-Content-Type: text/markdown", "",
        (ROOT / PROJECT["readme"]).read_text()])


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """The program of the Python that runs this is the one that the module is compiled for."""
    program = sysconfig.get_config_var("BINDIR") + "/python" + sysconfig.get_config_var("VERSION")
    _run("cmake", "--preset", "release", "-D", "KINETOSTAT_PYTHON=ON", "-D", f"Python3_EXECUTABLE={program}")
    _run("cmake", "--build", "--preset", "release", "--parallel", str(os.cpu_count()), "--target", "kinetostat_python",
         "kinetostat-helpers")
    packed = sorted(file for file in PACKAGE.iterdir() if file.is_file())
    programs = [file for file in HELPERS if file.exists()]  # those whose libraries were there
    files = {f"kinetostat/{file.name}": file.read_bytes() for file in packed + programs}
    info = f"{NAME}.dist-info"
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: kinetostat\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{info}/RECORD"] = _record(files, info).encode()
    wheel = f"{NAME}-{_tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, date_time=(2020, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            is_program = name in {f"kinetostat/{file.name}" for file in programs}
            entry.external_attr = (0o100755 if is_program else 0o100644) << 16
            archive.writestr(entry, content)
    return wheel


def _record(files, info):
    rows = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.append(f"{name},sha256={digest},{len(content)}")
    return "\n".join([*rows, f"{info}/RECORD,,", ""])
