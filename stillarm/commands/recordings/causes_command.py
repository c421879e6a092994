"""`stillarm causes`: every cause that can be declared, hidden and named, from its declaration."""

import argparse
import difflib
import json

from stillarm.causes_page import ALL_CAUSES, page, place_of, schema, section
from stillarm.common.user_error import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="all that is said of one cause")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="all causes, as docs/causes.md has them")
    form.add_argument("--schema", action="store_true", help="the JSON schema of an entry of [[effects]]")


def run(arguments: argparse.Namespace) -> int:
    """Print a list, one cause, the page or the schema. Raises UserError for a name that is no cause's."""
    if arguments.markdown:
        print(page(), end="")
    elif arguments.schema:
        print(json.dumps(schema(), indent=2))
    elif arguments.name is None:
        for cause in ALL_CAUSES.values():
            print(f"{cause.identifier:<32} {place_of(cause):<14} {cause.name}")
    elif arguments.name in ALL_CAUSES:
        print(section(ALL_CAUSES[arguments.name]), end="")
    else:
        near = difflib.get_close_matches(arguments.name, ALL_CAUSES, n=1, cutoff=0.0)[0]
        raise UserError(
            f"causes {arguments.name}: no such cause; the nearest is {near}, and `stillarm causes` lists all"
        )
    return 0
