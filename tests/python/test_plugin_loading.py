# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the package finds the plugin, and what it says when the plugin does not fit."""

import os
import re
import shutil

import pytest
from mesh_paths import REPOSITORY
from processes import run_program, run_python

import spheroseg
from spheroseg.api import SEGMENT_FILTER
from spheroseg.install import PLUGIN_FILE


@pytest.fixture(scope="module")
def other_release(tmp_path_factory):
    """The plugin, marked as one for an older release."""
    path = tmp_path_factory.mktemp("other") / PLUGIN_FILE
    built = spheroseg.plugin_path().read_bytes()
    assert b"MeshLab 2025.07d" in built
    path.write_bytes(built.replace(b"MeshLab 2025.07d", b"MeshLab 2023.12d"))
    return path


def test_the_environment_variable_comes_first(monkeypatch, tmp_path):
    copy = shutil.copy(spheroseg.plugin_path(), tmp_path / "mine.so")
    monkeypatch.setenv("SPHEROSEG_PLUGIN", str(copy))
    assert spheroseg.plugin_path() == copy


def test_a_variable_that_names_no_file_is_an_error_that_quotes_it(monkeypatch):
    monkeypatch.setenv("SPHEROSEG_PLUGIN", "/no/where.so")
    with pytest.raises(spheroseg.PluginError, match="SPHEROSEG_PLUGIN names '/no/where.so'"):
        spheroseg.plugin_path()


def test_a_plugin_beside_the_package_comes_before_the_build_folder(tmp_path):
    package = tmp_path / "python" / "spheroseg"
    shutil.copytree(REPOSITORY / "python" / "spheroseg", package)
    built = tmp_path / "build" / "plugin" / PLUGIN_FILE
    show = ["-c", "import spheroseg; print(spheroseg.plugin_path())"]
    environment = {"PYTHONPATH": str(tmp_path / "python"), "SPHEROSEG_PLUGIN": ""}

    missing = run_python(*show, **environment)
    assert missing.returncode == 1
    assert "PluginError: The MeshLab plugin is not built" in missing.stderr
    assert str(built) in missing.stderr

    built.parent.mkdir(parents=True)
    source = spheroseg.plugin_path()
    shutil.copy(source, built)
    assert run_python(*show, **environment).stdout.strip() == str(built)

    shutil.copy(source, package)
    assert run_python(*show, **environment).stdout.strip() == str(package / PLUGIN_FILE)


AWAY = """
import os, sys
import spheroseg
from spheroseg.api import TETRAHEDRON

os.unlink(sys.argv[1])
os.chdir("/")
print(spheroseg.segment(*TETRAHEDRON, 4).measures["submesh_count"])
"""


def test_a_plugin_that_is_loaded_is_not_looked_for_again(tmp_path):
    copy = shutil.copy(spheroseg.plugin_path(), tmp_path / PLUGIN_FILE)
    run = run_python("-c", AWAY, copy, SPHEROSEG_PLUGIN=os.path.relpath(copy))
    assert (run.returncode, run.stdout) == (0, "4\n"), run.stderr


def test_a_plugin_for_another_release_is_refused_with_both_releases(other_release):
    run = run_python("-c", "import spheroseg", SPHEROSEG_PLUGIN=str(other_release))
    assert run.returncode == 1
    message = run.stderr.strip().splitlines()[-1]
    assert "PluginError" in message
    assert "built for PyMeshLab 2023.12 (MeshLab 2023.12)" in message
    assert "PyMeshLab 2025.7" in message
    assert "(MeshLab 2025.07) is installed" in message


def test_a_plugin_in_single_precision_is_refused_with_the_reason(tmp_path):
    path = tmp_path / PLUGIN_FILE
    built = spheroseg.plugin_path().read_bytes()
    path.write_bytes(built.replace(b"07d (double)", b"07d (float)\0"))
    run = run_python("-c", "import spheroseg", SPHEROSEG_PLUGIN=str(path))
    assert run.returncode == 1
    assert "single precision; PyMeshLab needs one in double" in run.stderr


@pytest.mark.parametrize("content", ["", "no library"])
def test_a_file_that_is_no_plugin_is_refused(tmp_path, content):
    path = tmp_path / PLUGIN_FILE
    path.write_text(content)
    run = run_python("-c", "import spheroseg", SPHEROSEG_PLUGIN=str(path))
    assert run.returncode == 1
    assert f"PluginError: {path} is not a SpheroSeg plugin" in run.stderr


def test_a_plugin_that_was_copied_in_part_is_refused_with_the_reason(tmp_path):
    path = tmp_path / PLUGIN_FILE
    path.write_bytes(spheroseg.plugin_path().read_bytes()[:-1000])
    run = run_python("-c", "import spheroseg", SPHEROSEG_PLUGIN=str(path))
    assert run.returncode == 1
    message = run.stderr.strip().splitlines()[-1]
    assert f"can not load the plugin {path}: " in message
    assert "invalid ELF object" in message
    assert message.endswith("Build it again for this release (`make plugin`).")


def test_the_command_line_says_it_in_one_line_and_still_shows_its_help(other_release, tmp_path):
    environment = {"SPHEROSEG_PLUGIN": str(other_release)}
    cube = REPOSITORY / "sample_meshes" / "cube.obj"
    run = run_program("segment", cube, **environment)
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert "2023.12" in run.stderr
    assert "2025.07" in run.stderr
    assert run_program("--help", **environment).returncode == 0


@pytest.mark.parametrize("call", [["-P", "-m", "spheroseg"], ["-mspheroseg"]])
def test_the_command_line_is_known_however_python_is_told_to_run_it(call, other_release):
    run = run_python(*call, "--help", SPHEROSEG_PLUGIN=str(other_release))
    assert (run.returncode, run.stderr) == (0, "")


@pytest.mark.parametrize("module", ["foreign", "spherosegment"])
def test_the_module_of_somebody_else_is_told_at_the_import(module, other_release, tmp_path):
    (tmp_path / f"{module}.py").write_text("import spheroseg; print('imported')")
    path = os.pathsep.join([str(REPOSITORY / "python"), str(tmp_path)])
    run = run_python("-m", module, SPHEROSEG_PLUGIN=str(other_release), PYTHONPATH=path)
    assert (run.returncode, run.stdout) == (1, "")
    assert "PluginError: " in run.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize("module", ["demo", "bench"])
def test_modules_of_the_package_say_it_in_one_line(module, other_release, tmp_path):
    output = ["--output", tmp_path / "out"] if module == "bench" else [tmp_path / "out"]
    run = run_python("-m", f"spheroseg.{module}", *output, SPHEROSEG_PLUGIN=str(other_release))
    assert (run.returncode, run.stderr.count("\n")) == (1, 1)
    assert "built for PyMeshLab 2023.12" in run.stderr
    assert not (tmp_path / "out").exists()


def test_the_demo_says_where_its_folder_can_not_be_made(tmp_path):
    (tmp_path / "file").touch()
    run = run_python("-m", "spheroseg.demo", tmp_path / "file" / "out")
    assert (run.returncode, run.stdout, run.stderr.count("\n")) == (1, "", 1)
    assert f"{tmp_path}/file/out" in run.stderr


def imports_of_the_documents():
    """The lines of README.md and docs/ that import the package together with PyMeshLab."""
    paths = [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").glob("*.md"))]
    pattern = re.compile(r"import [a-z, ]*\bspheroseg\b[a-z, ]*")
    found = {(path.name, line) for path in paths for line in pattern.findall(path.read_text())}
    return sorted((name, line.strip()) for name, line in found if "pymeshlab" in line)


@pytest.mark.parametrize("line", sorted({line for _, line in imports_of_the_documents()}))
def test_imports_of_the_documents_come_before_openmp_reads_its_settings(line):
    # GNU's library, asked by OMP_DISPLAY_ENV, tells when it is loaded how long threads will spin.
    unset = "import os; del os.environ['OMP_WAIT_POLICY'], os.environ['GOMP_SPINCOUNT']"
    environment = {"OMP_DISPLAY_ENV": "verbose", "OMP_WAIT_POLICY": "", "GOMP_SPINCOUNT": ""}
    told = run_python("-c", f"{unset}; {line}", **environment)
    assert told.returncode == 0
    assert "OMP_WAIT_POLICY = 'PASSIVE'" in told.stderr
    assert "GOMP_SPINCOUNT = '2000'" in told.stderr


def test_documents_show_the_import():
    assert {name for name, _ in imports_of_the_documents()} >= {"README.md", "python.md"}


@pytest.mark.parametrize(
    ("policy", "spins", "kept"),
    [
        ("active", None, "active None"),
        ("passive", "7", "passive 7"),
        ("PASSIVE", None, "PASSIVE 2000"),
    ],
)
def test_a_wait_policy_of_the_user_stays(policy, spins, kept):
    unset = "" if spins else "del os.environ['GOMP_SPINCOUNT'];"
    show = "print(*map(os.environ.get, ('OMP_WAIT_POLICY', 'GOMP_SPINCOUNT')))"
    line = f"import os; {unset} import spheroseg; {show}"
    told = run_python("-c", line, OMP_WAIT_POLICY=policy, GOMP_SPINCOUNT=spins or "")
    assert told.stdout == f"{kept}\n"


# Both threads of a segmentation on one core, where one that spins keeps the other from its work.
ONE_CORE_SCRIPT = """
import os, sys, time
del os.environ["OMP_WAIT_POLICY"], os.environ["GOMP_SPINCOUNT"]
{imports}

mesh_set = pymeshlab.MeshSet()
mesh_set.create_sphere(subdiv=5)
os.sched_setaffinity(0, {{min(os.sched_getaffinity(0))}})

def seconds(threads):
    began = time.process_time()
    mesh_set.apply_filter({name!r}, submesh_count=200, thread_count=threads)
    return time.process_time() - began

seconds(2)
print(sorted(seconds(2) for _ in range(3))[1] / sorted(seconds(1) for _ in range(3))[1])
"""


@pytest.mark.parametrize(
    "imports",
    [
        "import spheroseg, pymeshlab",
        "import pymeshlab, spheroseg",
        "import pymeshlab; pymeshlab.load_plugin({plugin!r})",
    ],
)
def test_threads_that_wait_do_not_spin_for_long(imports):
    """Whether OpenMP can have read the package's settings or not. (Spinning: 30 times the work.)"""
    imports = imports.format(plugin=str(spheroseg.plugin_path()))
    script = ONE_CORE_SCRIPT.format(imports=imports, name=SEGMENT_FILTER)
    told = run_python("-c", script, OMP_WAIT_POLICY="", GOMP_SPINCOUNT="")
    assert told.returncode == 0, told.stderr
    assert float(told.stdout) < 3


def test_importing_twice_or_loading_again_changes_nothing():
    assert spheroseg.load_plugin() == spheroseg.plugin_path()
