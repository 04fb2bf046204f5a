"""How a command ends: its exit code, and words instead of a traceback.

0 done; 1 a fault of orthospec itself; 2 wrong use or a wrong spec; 3 no design found in which every bound
holds, or one evaluated in which not every bound does; 4 stopped before the end; 5 a plugin failed.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from orthospec.errors import OrthospecError

DONE, FAULT, NOT_MET, STOPPED, PLUGIN = 0, 1, 3, 4, 5


def exit_code(work: Callable[[], int]) -> int:
    """The code that the work gives back, or that of what it raises, which is told on standard error."""
    try:
        code = work()
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except KeyboardInterrupt:
        say("stopped before there was a result")
        return STOPPED
    except OrthospecError as error:
        say(str(error))
        return error.exit_code
    except SystemExit as error:
        say(f"a plugin ended the program: SystemExit: {error}")
        return PLUGIN
    except Exception as error:
        say(_fault(error))
        return FAULT


def say(message: str) -> None:
    """A message to the user, beside the results."""
    print(message, file=sys.stderr)


def _fault(error: Exception) -> str:
    """A mistake of ours: named shortly, with the whole trace on request."""
    if os.environ.get("ORTHOSPEC_TRACEBACK"):
        return traceback.format_exc()
    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(last.filename).name}:{last.lineno}"
    return (
        f"fault in orthospec itself: {type(error).__name__}: {error} ({where})\n"
        "set ORTHOSPEC_TRACEBACK=1 to see where it comes from, and please report it"
    )
