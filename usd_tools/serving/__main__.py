"""python -m usd_tools.serving: started by other programs, which speak with it over stdin and stdout."""

import os
import sys

from usd_tools.serving.run import serve


def main() -> None:
    """Serve on stdin and stdout; what is printed meanwhile goes to stderr, so that it breaks no message."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
