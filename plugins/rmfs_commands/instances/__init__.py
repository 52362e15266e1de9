"""Where instances come from that no file has: the paper's generator, an entry point of the group ``rmfs.instances``."""
