"""SKUs and pods, placed by a history of orders: `rmfs slot`."""
