"""`rmfs replay`: a recorded run as a page to watch, as pictures, or as a video."""
