"""Robots that decide together whether they can do the tasks they see, as nodes of ROS 2."""

import os
from pathlib import Path

# Fast DDS asks other nodes for the types of their topics. Nobody here needs the answers, and the thread that
# takes them reads a table while another changes it: in 4 of 251 fields of 20 nodes, one ended by SIGSEGV.
os.environ.setdefault("FASTDDS_DEFAULT_PROFILES_FILE", str(Path(__file__).with_name("fastdds.xml")))
