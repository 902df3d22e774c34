"""The HTML page of runs: `document` says its order, `tables` and `figures` draw, `facts` reckon."""
