"""`python -m stillarm` is the command `stillarm`."""

import sys

from stillarm.main import main

sys.exit(main())
