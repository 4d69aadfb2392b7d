/* The records of which the scene's arrays are made, and the numbers that name kinds and flags.
 * Everything is world space relative to the scene's origin unless a comment says object space. */
#ifndef ISOPHOTE_SCENE_RECORDS_H
#define ISOPHOTE_SCENE_RECORDS_H
#include "types.h"

#define NONE 0xffffffffu

/* Kinds of rays, as bits: an object's visibility is a mask of them (Blender's ray visibility). */
#define RAY_CAMERA 1u
#define RAY_DIFFUSE 2u
#define RAY_GLOSSY 4u
#define RAY_TRANSMISSION 8u
#define RAY_SHADOW 16u
#define RAY_ALL 31u
#define CATCHER_SHIFT 10 /* objects that catch shadows have their visibility a second time, so much higher */
#define RAY_INDIRECT 14u /* those that a surface sends on: diffuse, glossy, transmission */
/* How the ray was made, beside its kind. */
#define RAY_SINGULAR 32u /* by a mirror or by smooth glass */
#define RAY_SOFT 64u     /* of transmission: by a closure that is diffuse */
#define RAY_AFTER_DIFFUSE 128u /* a surface before has scattered it diffusely; where there is FEATURE_SUBSURFACE */

/* What a scene uses: kernels are specialised to it, loops over nothing are skipped. */
#define FEATURE_INSTANCES 1u
#define FEATURE_SPHERES 2u
#define FEATURE_TRANSPARENT 4u
#define FEATURE_VISIBILITY 8u    /* some object hides from some kind of ray */
#define FEATURE_LIGHTS 16u       /* something to sample */
#define FEATURE_VISIBLE_LIGHTS 32u /* lamps that rays can run into */
#define FEATURE_SMOOTH 64u
#define FEATURE_EMISSION 128u
#define FEATURE_LAMPS 256u     /* lights to sample that are no triangles */
#define FEATURE_SLOTS 512u     /* some triangle has another material slot than 0 */
#define FEATURE_VALUES 1024u   /* some material computes values for each point, or the UV pass shows an attribute */
#define FEATURE_BUMP 2048u     /* some closure has a normal of its own */
#define FEATURE_WORLD 4096u    /* the world's radiance is computed for each direction */
#define FEATURE_WORLD_LIGHT 8192u /* and it is drawn as a light: the last of the lamps */
#define FEATURE_SHINES 16384u  /* some light's radiance is computed where it is drawn */
#define FEATURE_LENS 32768u /* a camera with a lens: depth of field */
#define FEATURE_LAMP_SHAPES 65536u /* an area lamp with a spread, or a stretched spot */
#define FEATURE_LIGHT_LIMITS 131072u /* a light that some kinds of rays, or paths of many bounces, do not see */
#define FEATURE_LAMP_PROGRAMS 262144u /* a lamp whose radiance a material's emission is multiplied with */
#define FEATURE_WORLD_SUN 524288u /* a disc of the world is drawn apart from its map */
#define FEATURE_PANORAMA 1048576u /* a camera that is neither perspective nor orthographic */
#define FEATURE_CAMERA_MOTION 2097152u /* the camera moves while its shutter is open */
#define FEATURE_SUBSURFACE 4194304u /* light wanders about below some surface */
#define FEATURE_MOTION 8388608u /* some instance moves, or its mesh deforms, while the shutter is open */
#define FEATURE_DEFORMATION 16777216u /* some mesh deforms */
#define FEATURE_TERMINATOR 33554432u /* rays from some smooth mesh to lights start above its triangles: terminator.h */
#define FEATURE_CATCHERS 67108864u /* some object catches shadows */
#define FEATURE_LINKING 134217728u /* some light does not light, or is not stopped by, all objects */
#define FEATURE_VOLUME 268435456u /* something fills the world or the inside of an object */
#define FEATURE_STRANDS 536870912u /* hair and the like: strand.h */
/* Those of the scene at hand where code is compiled for one scene, else all. */
#ifndef SCENE_FEATURES
#define SCENE_FEATURES 0xffffffffu
#endif

#define CAMERA_PERSPECTIVE 0
#define CAMERA_ORTHOGRAPHIC 1
#define CAMERA_EQUIRECTANGULAR 2 /* from here on panoramas: panorama.h */
#define CAMERA_CYLINDER 3
#define CAMERA_CUBE_FACE 4
#define CAMERA_MIRROR_BALL 5
#define CAMERA_EQUIDISTANT 6
#define CAMERA_EQUISOLID 7
#define CAMERA_POLYNOMIAL 8
#define CAMERA_KINDS 9

typedef struct {
  packed3 x, y, z, position; /* axes of the camera in the world; it looks along -z, panoramas along x */
  float left, right, bottom, top; /* window at distance 1 (perspective), in metres (orthographic) or as panorama.h has it */
  float pixel; /* mean of a pixel's width and height in the middle: at distance 1, metres for an orthographic camera */
  float clip_start, clip_end;
  float lens, focus; /* radius of a thin lens, 0: a point; distance that it has in focus */
  int blades; /* of its aperture, 0: round */
  float blade_rotation, lens_ratio; /* radians; height over width */
  int kind;
  int width, height; /* of the full frame, pixels */
  float reach;            /* how far from the middle a panorama sees */
  float polynomial[5];    /* of CAMERA_POLYNOMIAL */
  float shift_x, shift_y; /* of a panorama's window */
  float eye, convergence; /* of spherical stereo: offset to the side, distance where eyes meet, 0: nowhere; metres */
  float merge_from, merge_to; /* elevations between which the offset fades, radians; 0: it stays */
  int poses;     /* records that follow, where the camera moves */
  float turn[4]; /* of these: from the camera's axes to theirs */
} Camera;

/* A reference into the tree: kind in the two highest bits, index in the others. */
#define REF_NODE 0u
#define REF_TRIANGLES 1u /* a run of triangles that ends at the one marked LAST_IN_LEAF */
#define REF_SPHERE 2u
#define REF_INSTANCE 3u
#define REF_SINGLE REF_SPHERE /* in the tree of a mesh that deforms, or of strands: the number of one triangle or segment */
#define REF_KIND(ref) ((ref) >> 30)
#define REF_INDEX(ref) ((ref) & 0x3fffffffu)
#define LAST_IN_LEAF 0x80000000u

/* BVH2 node, 64 bytes, holding the boxes of both children (Aila and Laine 2009): center and half the size. */
typedef struct {
  float center_x[2], half_x[2], center_y[2], half_y[2], center_z[2], half_z[2];
  uint child[2];
  uint unused[2];
} Bvh2Node;

/* What tracing reads of a triangle, in the order of the tree's leaves. Triangles of meshes with one user lie in
 * world space; the others in object space, reached through an Instance. Shading reads the mesh instead. */
typedef struct {
  packed3 v0;
  uint primitive; /* number in the scene's order: decides ties */
  packed3 v1;
  uint instance; /* of world-space triangles; NONE in object space */
  packed3 v2;
  uint flags; /* visibility << 16 | LAST_IN_LEAF */
} Triangle;

typedef struct {
  packed3 center;
  float radius;
  uint material, visibility;
} Sphere;

#define VECTORS_CAMERA 1u
#define VECTORS_MOTION 2u
typedef struct {
  packed3 radiance; /* the same from all directions; where FEATURE_WORLD is set it counts for nothing */
  packed3 origin;   /* place of the scene's origin in Blender's world: for the Position pass */
  uint root;        /* reference to the tree, NONE where there is nothing to hit */
  uint light_count; /* lights to sample: lamps, then triangles */
  uint lamp_count;  /* of them, lamps */
  uint light_depth; /* steps down the light tree; 0 where there is one light or none */
  uint attributes;  /* of each mesh, in mesh_attributes */
  uint registers;   /* that the materials' steps use */
  uint instance_columns; /* of instance_values, for each instance */
  uint features; /* FEATURE_ bits of the scene */
  uint material; /* whose emission is the world's radiance, where FEATURE_WORLD is set */
  uint hidden;   /* kinds of rays that do not see the world */
  uint map_width, map_height; /* cells of world_map */
  packed3 sun;      /* where FEATURE_WORLD_SUN is set: unit direction of the middle of a disc, */
  float sun_width;  /* 1 less the cosine of half its angle, */
  float sun_chance; /* and how often it is drawn instead of the map */
  float mist_start, mist_scale; /* where mist begins, one over its depth: for the Mist pass */
  float mist_falloff;           /* exponent: 1, 2 or 0.5 */
  float occlusion_distance;     /* within which surfaces occlude in the Ambient Occlusion pass */
  uint uv;                      /* attribute that the UV pass shows; NONE: black */
  uint aovs; /* AOV outputs of each material */
  uint vectors; /* VECTORS_ of the Vector pass: what is known of the frames around; 0: nothing */
  uint light_group;   /* of the world */
  uint sphere_groups; /* where those of spheres begin in light_groups; NONE: no object has one */
  uint sphere_indices, material_indices; /* where those of spheres and of materials begin in pass_indices */
  uint volume;          /* the material that fills the world; NONE: nothing does */
  uint camera_enclosed; /* 1: paths may begin in volumes of objects */
  uint sphere_links, lamp_links; /* where those of spheres and of lamps begin in links */
  uint receiver_sets; /* that lit_shares tells apart */
  uint mattes; /* where ids for Cryptomatte begin in it, of objects and assets in turn; NONE: there are none */
  uint sphere_mattes, material_mattes; /* how many instances there are before spheres; where those of materials begin */
} World;

/* Of triangles that lie in world space, mirrored on the way: the second and third corner change places, so that the
 * front stays the front. */
#define INSTANCE_MIRRORED 0x100u
#define INSTANCE_SMOOTH 0x200u /* its mesh has normals */
#define INSTANCE_STRANDS 0x8000u /* its mesh has radii: strand.h */
typedef struct {
  float to_world[12];  /* 3 rows of 4 */
  float to_object[12]; /* 3 rows of 4 */
  uint root;           /* reference to the mesh's tree; NONE where its triangles lie in world space */
  uint first_slot;     /* in slot_materials */
  uint visibility;     /* kinds of rays | INSTANCE_ flags */
  uint first_normal;   /* a vertex's number and this add up, modulo 2^32, to that of its normal, of strands its radius */
} Instance;

/* Of an instance: what there is of it while the shutter is open. One that moves, and one whose mesh deforms, has a tree
 * of its own. */
typedef struct {
  uint first_pose, poses;    /* 0: it stays; else at least 2, evenly over the time */
  uint first_shape, shapes;  /* likewise of its mesh; a vertex's number and first_shape add up, modulo 2^32, to its place
                              * in the first shape, */
  uint first_normal;         /* and its number and this to that of its normal, */
  uint vertices;             /* and so many vertices on they have the next shape */
} Motion;

/* Where an instance is at a time: stretched by a symmetric matrix, turned by a quaternion (x, y, z, w), moved. */
typedef struct {
  float turn[4];
  packed3 place;
  packed3 diagonal, mixed; /* of the matrix; mixed: xy, xz, yz */
} Pose;

#define MATERIAL_EMITS 1u
#define MATERIAL_TRANSPARENT 2u /* has an OP_TRANSPARENT: shadow rays pass in part */
#define MATERIAL_DELTA_ONLY 4u  /* nothing to gain from light sampling */
#define MATERIAL_TRANSMITS 8u   /* light from behind the surface counts */
#define MATERIAL_EMISSION_VARIES 16u     /* emission holds registers */
#define MATERIAL_TRANSPARENCY_VARIES 32u /* transparency holds registers */
#define MATERIAL_BUMPS 64u      /* a closure has a normal of its own */
#define MATERIAL_HOLDS_OUT 128u /* has an OP_HOLDOUT: takes of the pixel's alpha */
#define MATERIAL_SUBSURFACE 256u /* has an OP_SUBSURFACE */
#define MATERIAL_BOUNDARY 4096u /* of a volume: there is no surface */
#define MOST_VOLUMES 8u /* that a path can be in at once */
typedef struct {
  uint first, count; /* instructions; behind them where the scene has FEATURE_SUBSURFACE that of light that comes out */
  uint flags;
  packed3 emission;     /* radiance, both sides; of a volume per metre */
  packed3 transparency; /* what a shadow ray keeps; of a volume its extinction, 1/m */
  uint first_step, steps; /* what computes its values */
  uint shadow_steps;      /* of them, the first ones, which transparency needs */
  uint volume;            /* the material that fills what it encloses; NONE: nothing does */
  float majorant;         /* of a volume that differs from point to point: an extinction that it hardly exceeds; else 0 */
} Material;

/* One closure or layer of a material, 64 bytes (bsdf/bsdf.h lists the operations). Weight and parameters are constants,
 * or, of one that varies, numbers of the registers that hold them. */
#define INSTRUCTION_PARAMS 11
#define MOST_INSTRUCTIONS 32 /* of a material, emission not counted */
#define INSTRUCTION_VARIES 1u
#define INSTRUCTION_BUMPS 2u /* its normal is not the surface's */
#define INSTRUCTION_SOFTENED 4u /* of a diffuse closure: the edge that the surface's normal casts on it is softened */
#define INSTRUCTION_NORMAL(flags) (((flags) >> 8) & 255u) /* of one that varies: first of three registers */
#define INSTRUCTION_TANGENT(flags) ((flags) >> 16) /* likewise, plus 1, of its frame's x axis; 0: any will do */
typedef struct {
  int op;
  uint flags;
  packed3 weight;
  float params[INSTRUCTION_PARAMS];
} Instruction;

/* What an AOV output of a material shows: a colour and 1, or a number. */
#define AOV_THERE 1u
#define AOV_VARIES 2u /* value holds registers */
typedef struct {
  uint plane;  /* first of its planes, counted from the first that is named */
  uint color;
  uint flags;
  packed3 value;
} AovOutput;

/* One step of what computes a material's values, 64 bytes (values/values.h lists the operations): reads registers, and
 * writes those from `to` on. */
#define STEP_INPUTS 11
#define MOST_REGISTERS 192
typedef struct {
  int op;
  uint to;
  uint from[STEP_INPUTS];
  uint repeat;  /* how often it runs, once for each octave or neighbour */
  uint data;    /* what it reads beside: first entry in value_tables, number of an image or an attribute */
  float number; /* a constant */
} ValueStep;

/* Attributes of meshes: where the values are, for each mesh and attribute. */
#define DOMAIN_NONE 0u /* the mesh has no such attribute: 0 */
#define DOMAIN_MESH 1u /* one value */
#define DOMAIN_VERTEX 2u
#define DOMAIN_TRIANGLE 3u
#define DOMAIN_CORNER 4u
typedef struct {
  uint first;      /* in attribute_values: this and `components` times the number of vertex, triangle or corner of the
                    * scene add up, modulo 2^32, to the place of its first component */
  uint domain;
  uint components; /* 1 to 4 */
} MeshAttribute;

/* A picture; rows from the bottom up. Those that share their texels differ in their flags. */
#define TEXEL_FOLD(texel) ((texel) & 3u) /* a word holds 1 << this channels */
#define TEXEL_NUMBER 4u /* a floating-point number, else a fraction */
#define TEXEL_BYTE 2u
#define TEXEL_SHORT 1u
#define TEXEL_HALF 5u
#define TEXEL_FLOAT 4u
#define IMAGE_SRGB 1u /* data of the step stored_color: stored by sRGB's curve */
#define IMAGE_DIVIDE_ALPHA 2u /* likewise: stored times alpha, wanted without */
#define IMAGE_INTERPOLATION(flags) ((flags) & 3u) /* 1 << this texels count in each direction */
#define IMAGE_CLOSEST 0u
#define IMAGE_LINEAR 1u
#define IMAGE_CUBIC 2u
#define IMAGE_EXTENSION(flags) (((flags) >> 2) & 3u)
#define IMAGE_ENDS 1u    /* bits of it: once, and not over and over */
#define IMAGE_SPECIAL 2u /* every second one mirrored; nothing beyond the end */
#define IMAGE_REPEAT 0u
#define IMAGE_EXTEND 1u
#define IMAGE_MIRROR 2u
#define IMAGE_CLIP 3u
typedef struct {
  uint first; /* word of texels */
  int width, height, channels; /* 1, 3 or 4 channels */
  uint texel, flags;
} Image;

/* In a row of world_map: a power of 2, whose steps find one of them. */
#define MOST_MAP_CELLS 4096u

#define LIGHT_POINT 0    /* sphere of radius size.x; a true point where 0 */
#define LIGHT_SPOT 1     /* the same, limited to a cone around -z */
#define LIGHT_SUN 2      /* disk of directions of half angle size.x around -z; one direction where 0 */
#define LIGHT_RECTANGLE 3 /* size.x by size.y, shines along -z */
#define LIGHT_ELLIPSE 4
#define LIGHT_TRIANGLE 5 /* made from emissive triangles when the scene is prepared */
#define LIGHT_WORLD 6    /* radiance: its mean */
#define LIGHT_NO_SHADOW 1u
#define LIGHT_NO_MIS 2u
#define LIGHT_DISK 4u /* points and spots: a disk that faces whoever looks, Blender's soft falloff */
/* What counts is computed where the light is drawn (shine.h). Of triangles and the world radiance is an estimate; that of
 * lamps is to be multiplied with what their material emits. */
#define LIGHT_COMPUTED 8u
#define LIGHT_STRETCHED 16u /* spots: u and v have lengths by which the cone is not round */
#define LIGHT_BOUNCES_SHIFT 8
#define LIGHT_GROUP_SHIFT 16
#define LIGHT_BOUNCES(flags) (((flags) >> LIGHT_BOUNCES_SHIFT) & 255u) /* of a path, up to which a lamp is seen, and one more; 0: no limit */
#define LIGHT_GROUP(flags) ((flags) >> LIGHT_GROUP_SHIFT) /* 0: none, 1: the first */
typedef struct {
  int kind;
  uint flags;
  uint visibility;       /* kinds of rays that see it */
  uint instance, primitive; /* LIGHT_TRIANGLE: what a shadow ray must not be stopped by; of a computed lamp, its material */
  packed3 radiance;      /* W/(m^2 sr); radiant intensity W/sr of points; irradiance W/m^2 of sharp suns */
  packed3 position;      /* LIGHT_TRIANGLE: v0 */
  packed3 u, v;          /* unit axes; LIGHT_TRIANGLE: the edges v1-v0, v2-v0, unnormalised */
  packed3 normal;        /* unit, direction in which it shines */
  float size_u, size_v;  /* metres (half lengths of rectangles and ellipses, radius), radians (sun) */
  float area;            /* m^2 */
  float cone, cone_scale; /* spots: cosine of the half cone angle, and Blender's blend as in Cycles; area lamps: tangent
                           * of half the spread, and what makes up for it, 0 where there is none */
  uint trail;            /* bit d: which cluster of a pair it lies in, d steps below the light tree's root */
} Light;

#define MOST_SETS 64 /* of receivers, and of blockers of light: bits of a mask */
/* What links an object or a lamp to others (light_linking.h). */
typedef struct {
  uint receiver, blocker;            /* sets that an object is in */
  uint unlit[2], unblocked[2];       /* masks of sets of receivers that it does not light, of blockers that do not stop it */
} Link;

/* A cluster of the light tree (light_tree.h). Those at 2 k and 2 k + 1 are pair k; pair 0 is the root's. */
#define CLUSTER_LIGHT 0x80000000u /* in child: a light's number follows, else that of a pair */
#define CLUSTER_TWO_SIDED 1u
#define CLUSTER_DISTANT 2u /* suns: it has no place, intensity is an irradiance */
typedef struct {
  packed3 center; /* of a sphere around its lights */
  float radius;
  packed3 axis;     /* middle of the directions in which they shine, unit */
  float cos_axes;   /* cosine of the largest angle from axis to one of these; -1: all directions */
  float cos_edge;   /* cosine of the largest angle to such a direction under which a light still shines */
  float intensity;  /* sum of the lights' largest luminous intensities, W/sr; irradiances W/m^2 of suns */
  uint child;
  uint flags;
} LightCluster;

#endif
