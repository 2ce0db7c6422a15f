// SPDX-License-Identifier: GPL-3.0-or-later
// Every epsilon: name, unit, why.
#pragma once

namespace rumple {

// Unit: bounding box diagonals. Vertices of a seam that lie closer than this
// are one vertex. Exporters write both sides of a seam from one float; 1e-6
// forgives a few roundings (2 micrometres on a garment of 2 m) and is far below
// any gap that an artist models.
inline constexpr double kWeldDistance = 1e-6;

// Unit: object units. No coordinate is larger: products of four differences of them, which squared areas
// are, stay floats with room to be summed up. A garment in millimetres is 100 km away there.
inline constexpr float kFarthestCoordinate = 1e8f;

// Unit: largest coordinates of the rest shape. A frame with a vertex farther from the origin has exploded: a
// float there is rounded by a twentieth of the mesh. Simulations that burst pass it within a few frames.
inline constexpr float kExploded = 1e6f;

// Unit: bounding box diagonals. An edge shorter than this has no direction worth
// trusting in single precision. Only warned about.
inline constexpr double kZeroLength = 1e-6;

// Unit: squares of the triangle's longest edge. Twice the area below this means
// an altitude below a millionth of the edge: no normal worth trusting in single
// precision. Only warned about.
inline constexpr double kZeroArea = 1e-6;

// Unit: none (weights of rows that sum to 1). Below it a linear weight is a
// rounding of zero; real weights of eight subdivision levels are above 1e-5.
inline constexpr float kZeroWeight = 1e-6f;

// Unit: none (length over length). An edge may exceed the longest length asked for by
// this, so that a length equal but for rounding is not split once more.
inline constexpr double kLengthSlack = 1e-6;

// Unit: none, relative to a squared distance. A box of the hierarchy is opened
// although it is farther than the best triangle by this: both distances are
// rounded (doubles, about 1e-15), and a tie must reach the lowest triangle.
inline constexpr double kTieSlack = 1e-12;

// The same in single precision: of a distance of a millimetre, 1e-4 is the rounding of a triangle of
// centimetres.
inline constexpr float kPacketTieSlack = 1e-4f;

// Unit: none, relative to a coordinate: four units in its last place.
inline constexpr float kPlaceRounding = 2.4e-7f;

// Unit: object units. Edges shorter than this, and triangles of less than its square,
// have no direction: their frames are zero vectors. Far below any cloth, far
// above the smallest float whose square is still a float.
inline constexpr float kShortestEdge = 1e-12f;

// Unit: none (length of a sum of unit normals, or of a projected unit tangent).
// Below it the direction is noise.
inline constexpr float kShortestNormal = 1e-3f;

// Unit: none (cosine). Two normals so far apart have no smallest rotation.
inline constexpr float kOppositeNormals = -0.999f;

// Unit: none (strain). A vertex whose pairs changed their attachment length by
// less than kHeldStrain since they were last solved is held; from kFreeStrain on
// it is solved in full. Bone matrices in single precision jitter by about 1e-6;
// a fold starts to show at about 1e-2. The base cloth is held by the strain of its
// springs, and by how far the surface under it has moved: kHeldStrain as a share of
// `room`, or, where it swings, of the mean rest length of its springs.
inline constexpr float kHeldStrain = 2e-4f;
inline constexpr float kFreeStrain = 4e-3f;

// Unit: attachment radii. A held vertex is put back within its bounds when it is
// outside by more than this. An offset of 5 mm at 50 m from the origin is
// rounded by 1e-3 of itself; nobody sees so much.
inline constexpr float kHeldOutside = 1e-3f;

// Unit: largest distance of a rig's bones from its root. A bone that is displaced by
// less than this in a reference pose does not move in it. Bone matrices in single
// precision jitter by about 1e-7 of a figure's height, a head is a tenth of that.
inline constexpr double kStillBone = 1e-5;

// Unit: longest way of any bone in the same reference pose. A bone with a shorter way does not move in
// that pose: constraints and inverse kinematics leave so much behind, and on it every tremor is a step.
inline constexpr double kShortWay = 0.01;

// Unit: longest way of the same bone in any reference pose. A bone with a shorter way in a pose only passes
// by there on its way elsewhere: it would raise the pose's influence from 0 to 1 within a frame or two.
inline constexpr double kPassedBy = 0.1;

// Unit: none (sum of skin weights). Weights that miss 1 by less than this are a
// rounding: painted floats, or bytes of a game format.
inline constexpr double kWeightSum = 5e-3;

// Unit: none (difference of squared stretches over the larger one). Below it a triangle is
// stretched the same in all directions and has no direction of strongest compression.
inline constexpr double kSameStretch = 1e-9;

// Unit: none (length over length). A triangle folded up farther says nothing more.
inline constexpr float kMostCompression = 10.0f;

// Unit: none (stretch over stretch, less 1). A triangle stretched so evenly has no direction that
// a fold would follow: it keeps the one it came with.
inline constexpr float kEvenStretch = 0.05f;

// Unit: none (4 sqrt 3 area over the sum of squared edges). The direction of a thinner triangle is
// noise: its eigenvector turns by 10 degrees when a corner moves by a hundredth of an edge.
inline constexpr float kSliver = 0.15f;

// Unit: none (sine of an angle). A path that enters a triangle at a smaller angle runs along its edge.
inline constexpr double kShallow = 0.05;

// Unit: radians. A fold that has turned by so much ends: cloth folds in arcs, not in rings.
inline constexpr double kMostTurn = 1.75;

// Unit: edges. A path keeps so far from vertices: there it would lie on many edges at a time.
inline constexpr double kEdgeMargin = 1e-3;

// Unit: none (strain since a tenth of a second ago). A fold turns towards the compression only where
// the cloth moves: below the first not at all, as if by friction; above the second in full.
inline constexpr float kHeldChange = 2e-3f;
inline constexpr float kFreeChange = 2e-2f;

// Unit: fold widths. Moves of a path below this are not made: nobody sees a thousandth of a fold.
inline constexpr float kStill = 1e-3f;

// Unit: room of the base cloth. A cloth whose vertices move less in a step has come to rest: 0.01 mm where
// the room is 3 cm.
inline constexpr float kStillCloth = 3e-4f;

// Unit: mean lengths of the base cloth's springs. A frame whose vertices move less in a step is solved: 0.1
// mm where the edges are 3 cm.
inline constexpr float kSettledCloth = 3e-3f;

// Unit: mean lengths of the base cloth's springs per second. Cloth that swings slower than this has come to
// rest: 0.01 mm in a frame where the edges are 3 cm.
inline constexpr float kStillSwing = 1e-2f;

// Unit: room of the base cloth. Nearer to the inner surface than this, a vertex rests on it.
inline constexpr float kTouching = 1e-2f;

// Unit: object units. A point so near to a body lies on it: the way there is a rounding and has no direction.
inline constexpr float kOnBody = 1e-5f;

// Unit: none (cosine). Surfaces face one another when their normals are this far apart: a right angle, as
// around the edge of a box or along a seam that stands up, and six degrees more for what wavers about it.
inline constexpr float kFacingNormals = -0.1f;

// Unit: reaches (about two edges: centimetres). Nearer than this, the way between two points is mostly the
// rounding of their positions (1e-6 m at 10 m from the origin): the normal of what is met takes its place.
inline constexpr float kSamePlace = 1e-4f;

// Unit: none (barycentric weight). Samples of a cover lie on corners and in the middle of sides and polygons:
// a weight is 0, or far above this. What lies between is a rounding of 0, and says nothing of its corner.
inline constexpr float kLeastWeight = 1e-3f;

}  // namespace rumple
