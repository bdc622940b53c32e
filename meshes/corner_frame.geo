// Machine frame of an Orthoglide: three walls that meet in a corner, on three feet. Made for kinetostat.
// Regenerate corner_frame.stl: scripts/make-meshes. Units mm, in the axes of the robot's base: the walls stand behind
// the three guides, and a post on each carries one.
SetFactory("OpenCASCADE");

outer = -560;    // of the walls, away from the workspace
inner = 100;     // where they end
thickness = 40;
post = 80;       // square
face = -480;     // where the posts end, 30 mm behind the carriages at home
foot = 120; foot_height = 30;

size = inner - outer;
Box(1) = {outer, outer, outer, thickness, size, size};
Box(2) = {outer, outer, outer, size, thickness, size};
Box(3) = {outer, outer, outer, size, size, thickness};
// The axes of the carriages: (., -110, 0), (0, ., -110), (-110, 0, .).
length = face - outer;
Box(4) = {outer, -110 - post / 2, -post / 2, length, post, post};
Box(5) = {-post / 2, outer, -110 - post / 2, post, length, post};
Box(6) = {-110 - post / 2, -post / 2, outer, post, post, length};
far = inner - foot;
Box(7) = {outer, outer, outer - foot_height, foot, foot, foot_height};
Box(8) = {far, outer, outer - foot_height, foot, foot, foot_height};
Box(9) = {outer, far, outer - foot_height, foot, foot, foot_height};
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2 : 9}; Delete; };

Mesh.MeshSizeMin = 40;
Mesh.MeshSizeMax = 300;
