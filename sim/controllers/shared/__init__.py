"""Controllers in shared libraries, ``lib:./robot.so:act``."""
