// Arm whose rectangular section tapers. Made for kinetostat, to validate error bars.
// Regenerate tapered_arm.stl: scripts/make-meshes. Units mm. The arm runs along x from 0.
SetFactory("OpenCASCADE");

length = 180;
root_width = 50; root_height = 30;  // along y, z
tip_width = 24; tip_height = 16;

Rectangle(1) = {-root_width / 2, -root_height / 2, 0, root_width, root_height};
Rectangle(2) = {-tip_width / 2, -tip_height / 2, 0, tip_width, tip_height};
Translate {0, 0, length} { Surface{2}; }
Wire(3) = {1 : 4};
Wire(4) = {5 : 8};
Ruled ThruSections(1) = {3, 4};
Recursive Delete { Surface{1, 2}; }
// x, y, z of the drawing become y, z, x of the part.
Rotate {{1, 1, 1}, {0, 0, 0}, 2 * Pi / 3} { Volume{1}; }

Mesh.MeshSizeMin = 20;
Mesh.MeshSizeMax = 60;
