"""One period as plain data, and what is decided in it: the ground that the other folders stand on.

`period` reads it off the warehouse, `reduction` drops and counts what no optimum depends on, `solution` says which
lines go where and what that costs, `placing` and `decoding` find the order's line behind a number.
"""
