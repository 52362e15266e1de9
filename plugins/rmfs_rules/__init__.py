"""The shipped rules, a package each, behind entry points as those of others; and ``helpers``, which they share."""
