#!/bin/sh
# The command `spheroseg` of an environment, in whose folder bin this file lies. No interpreter line
# could name an environment whose path has a blank.
exec "$(dirname "$(readlink -f "$0")")/python" -P -m spheroseg "$@"
