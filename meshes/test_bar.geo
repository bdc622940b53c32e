// Prismatic test bar for comparison with beam theory and with CalculiX.
// Made for kinetostat. Regenerate test_bar.stl: scripts/make-meshes
// Units mm. The bar runs along x from the origin and is centred in y and z.
SetFactory("OpenCASCADE");

length = 310; width = 20; height = 12;
Box(1) = {0, -width / 2, -height / 2, length, width, height};
Transfinite Curve{:} = 2;  // no vertex besides the corners: twelve facets
Transfinite Surface{:};
