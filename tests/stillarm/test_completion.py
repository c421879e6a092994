"""Completion: bash runs the script, and every command and option is in each shell's."""

import argparse
import shutil
import subprocess

import pytest

from stillarm.completion import SHELLS, bash, command_of
from stillarm.main import COMMANDS, command_parser, main


def completed(script: str, *words: str) -> list[str]:
    """What bash offers for the last word."""
    line = " ".join(f"'{word}'" for word in words)
    ask = f"COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _stillarm; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    code = f"{script}\n{ask}"
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
    return sorted(set(done.stdout.split()))


@pytest.mark.slow
def test_bash_completes_commands_options_and_names() -> None:
    script = bash([command_of(name, text, command_parser(name)) for name, text in COMMANDS.items()])
    assert completed(script, "stillarm", "dia") == ["diagnose"]
    assert completed(script, "stillarm", "diagnose", "--bud") == ["--budget-s"]
    assert completed(script, "stillarm", "benchmark", "estim") == ["estimators"]
    assert completed(script, "stillarm", "completion", "f") == ["fish"]


@pytest.mark.slow
@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_knows_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for name in COMMANDS:
        assert name in script
        for option in command_of(name, "", command_parser(name)).options:
            assert all(one.lstrip("-") in script for one in option.names)


@pytest.mark.slow
@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_itself_finds_no_mistake(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Texts with quotes, brackets and colons among them."""
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    odd = argparse.ArgumentParser()
    odd.add_argument("-o", "--odd", choices=("a", "b"), help='it\'s [odd]: 50 %% $HOME `x` \\ "y"')
    script = SHELLS[shell]([command_of("odd", "it's: [odd] \\'", odd)])
    done = subprocess.run([shell, "-n"], input=script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
