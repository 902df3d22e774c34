"""One picture, as shapes: laid out, composed, and written as SVG and PNG."""
