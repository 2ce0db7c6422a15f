// SPDX-License-Identifier: GPL-3.0-or-later
// Enough of the Metal shading language, which is C++14, for clang++ to read the previews' GLSL as Blender's
// Metal backend hands it over: types and functions that its header gives, and no others. Nothing here
// computes. Constructors of vectors and matrices are calls in the text: vec3(...) has become make_vec3(...).
typedef float vec2 __attribute__((ext_vector_type(2)));
typedef float vec3 __attribute__((ext_vector_type(3)));
typedef float vec4 __attribute__((ext_vector_type(4)));
typedef int ivec2 __attribute__((ext_vector_type(2)));
typedef int ivec3 __attribute__((ext_vector_type(3)));
typedef int ivec4 __attribute__((ext_vector_type(4)));

template <typename Vector, int N>
struct Matrix {
    Vector columns[N];
    Vector& operator[](int i) { return columns[i]; }
    const Vector& operator[](int i) const { return columns[i]; }
    Matrix operator*(Matrix) const;
    Vector operator*(Vector) const;
    Matrix operator+(Matrix) const;
    Matrix operator-(Matrix) const;
    Matrix& operator+=(Matrix);
};
typedef Matrix<vec2, 2> mat2;
typedef Matrix<vec3, 3> mat3;
typedef Matrix<vec4, 4> mat4;

vec2 make_vec2(float);
vec2 make_vec2(float, float);
vec2 make_vec2(ivec2);
vec3 make_vec3(float);
vec3 make_vec3(float, float, float);
vec3 make_vec3(vec2, float);
vec3 make_vec3(float, vec2);
vec4 make_vec4(float);
vec4 make_vec4(float, float, float, float);
vec4 make_vec4(vec3, float);
vec4 make_vec4(vec2, float, float);
vec4 make_vec4(vec2, vec2);
ivec2 make_ivec2(int, int);
ivec2 make_ivec2(vec2);
ivec3 make_ivec3(vec3);
mat2 make_mat2(float);
mat2 make_mat2(vec2, vec2);
mat2 make_mat2(float, float, float, float);
mat3 make_mat3(mat4);
mat3 make_mat3(vec3, vec3, vec3);
mat4 make_mat4(float);
mat4 make_mat4(vec4, vec4, vec4, vec4);

#define FOR_EACH(OF) OF(float) OF(vec2) OF(vec3) OF(vec4)
#define ONE(T)        \
    T abs(T);         \
    T floor(T);       \
    T round(T);       \
    T sqrt(T);        \
    T exp2(T);        \
    T sin(T);         \
    T cos(T);         \
    T rsqrt(T);       \
    T normalize(T);   \
    float length(T);  \
    T dfdx(T);        \
    T dfdy(T);        \
    T fwidth(T);      \
    T pow(T, T);      \
    T max(T, T);      \
    T min(T, T);      \
    float dot(T, T);  \
    T reflect(T, T);  \
    T clamp(T, T, T); \
    T mix(T, T, T);
FOR_EACH(ONE)
#define WITH_SCALAR(T)        \
    T clamp(T, float, float); \
    T mix(T, T, float);       \
    T max(T, float);          \
    T min(T, float);
WITH_SCALAR(vec2) WITH_SCALAR(vec3) WITH_SCALAR(vec4) int abs(int);
int min(int, int);
int max(int, int);
vec3 cross(vec3, vec3);
template <typename M>
M transpose(M);
vec4 intBitsToFloat(ivec4);
ivec4 floatBitsToInt(vec4);

struct sampler2D {};
ivec2 textureSize(sampler2D, unsigned);
vec4 texelFetch(sampler2D, ivec2, unsigned);
vec4 texture(sampler2D, vec2);
struct image2D {};
ivec2 imageSize(image2D);
vec4 imageLoad(image2D, ivec2);
void imageStore(image2D, ivec2, vec4);
float atan(float, float);
float distance(vec3, vec3);
void discard_fragment();
#define inversesqrt rsqrt
#define discard discard_fragment()

// Words of the language, with which no name can be meant.
#pragma GCC poison vertex fragment kernel constant device thread threadgroup half ushort uchar ulong
#pragma GCC poison short char long double signed unsigned this new delete class template typename operator
#pragma GCC poison private public protected virtual namespace using union enum register goto sizeof try catch
#pragma GCC poison throw
