# SPDX-License-Identifier: GPL-3.0-or-later
"""Installing the plugin for the MeshLab application, with stand-ins for plugin and program."""

import errno

import pytest

from spheroseg import InputError, PluginError, cli, install


@pytest.fixture(autouse=True)
def _own_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:/usr/bin:/bin")


def make_plugin(folder, release="2025.07", scalar="float"):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "libfilter_spheroseg.so"
    path.write_bytes(
        b"\x7fELF\0" + f"SpheroSeg built for MeshLab {release} ({scalar})".encode() + b"\0"
    )
    return path


def make_meshlab(folder, answer):
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "meshlab"
    program.write_text(f"#!/bin/sh\necho '{answer}'\n")
    program.chmod(0o755)
    return program


def user_folder(tmp_path, precision="fp", release="2025.07"):
    return (
        tmp_path
        / "home/.local/share/VCG"
        / f"MeshLab_64bit_{precision}"
        / "MeshLabExtraPlugins"
        / release
    )


def test_finds_the_named_plugin_then_that_of_the_package_then_that_of_the_checkout(
    tmp_path, monkeypatch
):
    package = tmp_path / "source" / "python" / "spheroseg"
    monkeypatch.setattr(install, "__file__", str(package / "install.py"))
    monkeypatch.delenv(install.DESKTOP_PLUGIN_VARIABLE, raising=False)
    with pytest.raises(PluginError, match="is not built: expected it at .*desktop.*build/gui"):
        install.desktop_plugin_path()
    for folder in ("source/build/gui", "source/python/spheroseg/desktop"):
        path = make_plugin(tmp_path / folder)
        assert install.desktop_plugin_path() == path
    monkeypatch.setenv(install.DESKTOP_PLUGIN_VARIABLE, str(tmp_path / "none.so"))
    with pytest.raises(PluginError, match="SPHEROSEG_DESKTOP_PLUGIN names .*none.so"):
        install.desktop_plugin_path()
    named = make_plugin(tmp_path / "named")
    monkeypatch.setenv(install.DESKTOP_PLUGIN_VARIABLE, str(named))
    assert install.desktop_plugin_path() == named


def test_copies_the_plugin_into_the_users_folder_of_the_meshlab_on_the_path(tmp_path):
    plugin = make_plugin(tmp_path / "build")
    make_meshlab(tmp_path / "bin", "MeshLab 2025.07")
    copy = install.install_plugin(plugin=plugin)
    assert copy == user_folder(tmp_path) / "libfilter_spheroseg.so"
    assert copy.read_bytes() == plugin.read_bytes()


def test_a_copy_that_fails_leaves_the_plugin_that_was_there(tmp_path, monkeypatch):
    def fill_the_disk(_, target):
        target.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device", str(target))

    make_meshlab(tmp_path / "bin", "MeshLab 2025.07")
    plugin = make_plugin(tmp_path / "build")
    copy = install.install_plugin(plugin=plugin)
    monkeypatch.setattr(install.shutil, "copy2", fill_the_disk)
    with pytest.raises(OSError, match="no room left"):
        install.install_plugin(plugin=plugin)
    assert list(copy.parent.iterdir()) == [copy]
    assert copy.read_bytes() == plugin.read_bytes()


def test_a_double_precision_meshlab_has_its_own_folder(tmp_path):
    plugin = make_plugin(tmp_path / "build", release="2025.07d", scalar="double")
    program = make_meshlab(tmp_path / "other", "MeshLab 2025.07d")
    copy = install.install_plugin(plugin=plugin, meshlab=program)
    assert copy.parent == user_folder(tmp_path, "dp")


def test_the_data_folder_of_the_desktop_is_respected(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    make_meshlab(tmp_path / "bin", "MeshLab 2025.07")
    copy = install.install_plugin(plugin=make_plugin(tmp_path / "build"))
    assert tmp_path / "data" in copy.parents


def test_replaces_an_older_copy_and_leaves_nothing_beside_it(tmp_path):
    make_meshlab(tmp_path / "bin", "MeshLab 2025.07")
    folder = user_folder(tmp_path)
    make_plugin(folder, release="2023.12")
    plugin = make_plugin(tmp_path / "build")
    copy = install.install_plugin(plugin=plugin)
    assert copy.read_bytes() == plugin.read_bytes()
    assert list(folder.iterdir()) == [copy]


@pytest.mark.parametrize(
    ("release", "scalar", "answer", "names"),
    [
        ("2025.07", "float", "MeshLab 2023.12", ["2025.07", "2023.12"]),
        ("2025.07", "float", "MeshLab 2025.07d", ["single", "double"]),
        ("2025.07d", "double", "MeshLab 2025.07", ["single", "double"]),
    ],
)
def test_a_mismatch_names_both_values_and_copies_nothing(tmp_path, release, scalar, answer, names):
    plugin = make_plugin(tmp_path / "build", release, scalar)
    make_meshlab(tmp_path / "bin", answer)
    with pytest.raises(PluginError) as error:
        install.install_plugin(plugin=plugin)
    assert all(name in str(error.value) for name in names)
    assert not list(tmp_path.glob("home/**/*.so"))


def test_a_folder_of_extra_plugins_tells_its_release(tmp_path, monkeypatch):
    folder = user_folder(tmp_path, release="2022.02")
    folder.mkdir(parents=True)
    plugin = make_plugin(tmp_path / "build")
    monkeypatch.chdir(folder)
    for directory in (folder, "."):
        with pytest.raises(PluginError, match=r"2025\.07.*2022\.02"):
            install.install_plugin(directory, plugin=plugin)


def test_a_bare_folder_is_taken_at_its_word(tmp_path):
    folder = tmp_path / "plugins"
    folder.mkdir()
    copy = install.install_plugin(folder, plugin=make_plugin(tmp_path / "build"))
    assert copy.parent == folder


def test_rejects_what_is_missing_or_foreign(tmp_path):
    plugin = make_plugin(tmp_path / "build")
    with pytest.raises(InputError, match="no folder"):
        install.install_plugin(tmp_path / "nowhere", plugin=plugin)
    with pytest.raises(InputError, match="no plugin file"):
        install.install_plugin(tmp_path, plugin=tmp_path / "nothing.so")
    other = tmp_path / "other.so"
    other.write_bytes(b"\x7fELF")
    with pytest.raises(InputError, match="not a SpheroSeg plugin"):
        install.install_plugin(tmp_path, plugin=other)
    with pytest.raises(InputError, match="can not be run"):
        install.install_plugin(plugin=plugin, meshlab=tmp_path / "no-program")
    impostor = make_meshlab(tmp_path / "impostor", "Blender 4.2")
    with pytest.raises(InputError, match="Blender 4.2"):
        install.install_plugin(plugin=plugin, meshlab=impostor)


def test_without_a_meshlab_the_message_says_what_to_give(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    with pytest.raises(InputError, match="--meshlab PROGRAM"):
        install.install_plugin(plugin=make_plugin(tmp_path / "build"))


def test_the_command_says_what_it_did_and_ends_with_2_on_a_mismatch(tmp_path, capsys):
    plugin = make_plugin(tmp_path / "build")
    make_meshlab(tmp_path / "bin", "MeshLab 2025.07")
    assert cli.main(["install-plugin", "--plugin", str(plugin)]) == 0
    assert "MeshLab 2025.07 in single precision" in capsys.readouterr().out
    make_meshlab(tmp_path / "bin", "MeshLab 2022.02")
    assert cli.main(["install-plugin", "--plugin", str(plugin)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
