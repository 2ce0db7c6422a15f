// SPDX-License-Identifier: GPL-3.0-or-later
// Shared tolerances, each with its name, its unit and its reason. One that only a single file uses may stand
// there.
#pragma once

namespace rumple {

// Unit: bounding box diagonals. Vertices of a seam that are closer than this are one vertex. Exporters write
// both sides of a seam from one float. 1e-6 allows for a few roundings (2 micrometres on a garment of 2 m)
// and is far below any gap that an artist models.
inline constexpr double kWeldDistance = 1e-6;

// Unit: object units. No coordinate is larger, so that products of four differences of coordinates, such as
// squared areas, and sums of them do not overflow a float. For a garment in millimetres this is 100 km.
inline constexpr float kFarthestCoordinate = 1e8f;

// Unit: largest coordinates of the rest shape. A frame with a vertex farther from the origin has exploded: at
// this distance a float is rounded by a twentieth of the mesh. Unstable simulations pass it within a few
// frames.
inline constexpr float kExploded = 1e6f;

// Unit: bounding box diagonals. The direction of a shorter edge is not reliable in single precision. It only
// causes a warning.
inline constexpr double kZeroLength = 1e-6;

// Unit: squares of the triangle's longest edge. If twice the area is below this, the altitude is below a
// millionth of the edge, and the normal is not reliable in single precision. It only causes a warning.
inline constexpr double kZeroArea = 1e-6;

// Unit: none (weights of rows that sum to 1). A smaller linear weight is zero but for rounding. Real weights
// of eight subdivision levels are above 1e-5.
inline constexpr float kZeroWeight = 1e-6f;

// Unit: none (length / length). An edge may exceed the longest allowed length by this share, so that a length
// that is equal but for rounding is not split again.
inline constexpr double kLengthSlack = 1e-6;

// Unit: none, relative to a squared distance. A box of the hierarchy is still opened if it is farther than
// the best triangle by at most this. Both distances are rounded (doubles, about 1e-15), and among equal
// distances the lowest triangle must be found.
inline constexpr double kTieSlack = 1e-12;

// The same in single precision: 1e-4 of a distance of a millimetre is the rounding on a triangle of a few
// centimetres.
inline constexpr float kPacketTieSlack = 1e-4f;

// Unit: none, relative to a coordinate: four units in its last place.
inline constexpr float kPlaceRounding = 2.4e-7f;

// Unit: object units. Shorter edges, and triangles with less area than its square, have no direction: their
// frames are zero vectors. It is far below any cloth, and far above the smallest float whose square does not
// underflow.
inline constexpr float kShortestEdge = 1e-12f;
inline constexpr float kSmallestArea = kShortestEdge * kShortestEdge;

// Unit: none (length of a sum of unit normals, or of a projected unit tangent). The direction of a shorter
// vector is noise.
inline constexpr float kShortestNormal = 1e-3f;

// Unit: none (cosine). Between two normals with a smaller cosine the smallest rotation is not defined.
inline constexpr float kOppositeNormals = -0.999f;

// Unit: none (strain). A vertex is held if the attachment lengths of its pairs changed by less than
// kHeldStrain since they were last solved. From kFreeStrain on it is solved in full. Bone matrices in single
// precision jitter by about 1e-6. A fold becomes visible at about 1e-2. The base cloth is held by the strain
// of its springs, and by the movement of the surface under it: kHeldStrain is then a share of `room`, or, if
// the cloth swings, of the mean rest length of its springs.
inline constexpr float kHeldStrain = 2e-4f;
inline constexpr float kFreeStrain = 4e-3f;

// Unit: attachment radii. A held vertex is put back within its bounds if it is outside by more than this. An
// offset of 5 mm at 50 m from the origin is rounded by 1e-3 of itself, which is not visible.
inline constexpr float kHeldOutside = 1e-3f;

// Unit: largest distance of a rig's bones from its root. A bone does not move in a reference pose if its
// displacement is smaller. Bone matrices in single precision jitter by about 1e-7 of a figure's height, and a
// head is a tenth of this height.
inline constexpr double kStillBone = 1e-5;

// Unit: longest displacement of any bone in the same reference pose. A bone with a shorter displacement does
// not move in this pose. Constraints and inverse kinematics leave such small displacements, and with one of
// these as the reference every jitter would be a large change.
inline constexpr double kShortWay = 0.01;

// Unit: longest displacement of the same bone in any reference pose. A bone with a shorter displacement in a
// pose only passes it on its way to another pose. It would raise the pose's influence from 0 to 1 within a
// frame or two.
inline constexpr double kPassedBy = 0.1;

// Unit: none (sum of skin weights). Weights whose sum differs from 1 by less than this are equal to 1 but for
// rounding: painted floats, or bytes of a game format.
inline constexpr double kWeightSum = 5e-3;

// Unit: none (difference of squared stretches / the larger one). Below it a triangle is stretched equally in
// all directions and has no direction of strongest compression.
inline constexpr double kSameStretch = 1e-9;

// Unit: none (length / length). A larger compression of a triangle gives no more information.
inline constexpr float kMostCompression = 10.0f;

// Unit: none (stretch / stretch, minus 1). A triangle that is stretched so evenly has no direction that a
// fold would follow. The fold keeps its own direction.
inline constexpr float kEvenStretch = 0.05f;

// Unit: none (4 sqrt 3 area / the sum of squared edges). The direction of a thinner triangle is noise: its
// eigenvector turns by 10 degrees if a corner moves by a hundredth of an edge.
inline constexpr float kSliver = 0.15f;

// Unit: none (sine of an angle). A path that enters a triangle at a smaller angle runs along its edge.
inline constexpr double kShallow = 0.05;

// Unit: radians. A fold that has turned by more than this ends, because folds of cloth are arcs, not rings.
inline constexpr double kMostTurn = 1.75;

// Unit: edges. The least distance of a path from vertices, because a point at a vertex is on many edges at
// once.
inline constexpr double kEdgeMargin = 1e-3;

// Unit: none (strain since a tenth of a second ago). A fold turns towards the compression only while the
// cloth moves: below the first value not at all, as if by friction; above the second in full.
inline constexpr float kHeldChange = 2e-3f;
inline constexpr float kFreeChange = 2e-2f;

// Unit: fold widths. A path does not move by less than this, because a thousandth of a fold is not visible.
inline constexpr float kStill = 1e-3f;

// Unit: room of the base cloth. Cloth has come to rest if its vertices move less in a step: 0.01 mm for a
// room of 3 cm.
inline constexpr float kStillCloth = 3e-4f;

// Unit: mean lengths of the base cloth's springs. A frame is solved if its vertices move less in a step: 0.1
// mm for edges of 3 cm.
inline constexpr float kSettledCloth = 3e-3f;

// Unit: mean lengths of the base cloth's springs per second. Swinging cloth that is slower has come to rest:
// 0.01 mm per frame for edges of 3 cm.
inline constexpr float kStillSwing = 1e-2f;

// Unit: room of the base cloth. A vertex that is closer to the inner surface rests on it.
inline constexpr float kTouching = 1e-2f;

// Unit: object units. A point that is closer to a body is on it: the vector to the body is a rounding error
// without direction.
inline constexpr float kOnBody = 1e-5f;

// Unit: none (cosine). Surfaces face one another if the cosine between their normals is below this. This
// angle is a right angle, as around the edge of a box or along a seam that stands up, plus six degrees, so
// that variations around a right angle do not count.
inline constexpr float kFacingNormals = -0.1f;

// Unit: reaches (about two edges: centimetres). Below it the vector between two points is mostly the rounding
// error of their positions (1e-6 m at 10 m from the origin), so the normal of the surface there replaces it.
inline constexpr float kSamePlace = 1e-4f;

// Unit: none (barycentric weight). Samples of a cover are at corners and in the middle of sides and polygons,
// so a weight is 0 or far above this. A smaller weight is 0 but for rounding, and the sample does not count
// for its corner.
inline constexpr float kLeastWeight = 1e-3f;

}  // namespace rumple
