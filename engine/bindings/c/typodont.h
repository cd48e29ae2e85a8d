/* The C interface of Typodont, for C and for every language that can call C: scenes, hands, the haptic core, recorded
 * sessions. typodont_sound.h declares the sound and typodont_calibration.h the calibration; one library,
 * libtypodont.so, contains all functions.
 *
 *   typodont_scene* scene; typodont_core* core;
 *   typodont_scene_open("molar-caries", NULL, &scene);
 *   typodont_core_new(scene, NULL, NULL, &core);
 *   typodont_sample hand = {sizeof hand}; typodont_tick tick = {sizeof tick};
 *   ... each millisecond: fill `hand`, typodont_core_tick(core, &hand, &tick, NULL), apply tick.force to the hand ...
 *
 * Units are SI: m, N, N*m, s, rad, J, W. The letter W also names the workbench frame. T is the tool's frame: its origin
 * is the centre of the head, and its z axis points along the shank. Times are nanoseconds since the session's start.
 * The components of a quaternion have the order w, x, y, z.
 *
 * Results: every function that can fail returns a typodont_result. After a failure, typodont_error() returns the reason
 * in the same thread. A call that failed writes nothing through its output pointers, unless its comment states
 * otherwise.
 *
 * Handles: a handle is a number with the type of a pointer; the library never dereferences it. NULL, a handle of
 * another kind and a freed handle give TYPODONT_BAD_HANDLE. Only one thread at a time may use a handle: a second thread
 * gets TYPODONT_BUSY, and its call has no effect. Different handles are independent of each other.
 *
 * Threads: every thread may call the functions. The functions that are marked with TYPODONT_REALTIME never allocate,
 * lock or wait, so a real-time thread may call them. Call all other functions only from ordinary threads.
 *
 * Structs begin with `struct_size`, which the caller sets to the struct's sizeof. Later versions add members only at
 * the end. The first element's struct_size is the distance in bytes between the elements of an array. In an array that
 * the library fills, the caller needs to set struct_size only in the first element.
 */
#ifndef TYPODONT_H
#define TYPODONT_H

#include <stddef.h>
#include <stdint.h>

#define TYPODONT_VERSION "0.1.0"
#define TYPODONT_API __attribute__((visibility("default")))
#define TYPODONT_REALTIME

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t typodont_result;
enum {
  TYPODONT_OK = 0,
  TYPODONT_FAILED = 1,     /* the call failed although its input was valid: a full disk, a late thread */
  TYPODONT_BAD_INPUT = 2,  /* an argument, a file or a pose is not valid */
  TYPODONT_BAD_HANDLE = 3, /* the handle is NULL, freed, or of another kind */
  TYPODONT_BUSY = 4,       /* another thread is using this handle */
  TYPODONT_END = 5,        /* there are no more data */
  TYPODONT_NO_MEMORY = 6
};

/* The library's version, as static text. */
TYPODONT_API const char* typodont_version(void);
/* The error message of this thread's last call that did not return TYPODONT_OK. It is valid until this thread's next
 * call. */
TYPODONT_REALTIME TYPODONT_API const char* typodont_error(void);
/* The name of a tissue number, for example "enamel", as static text; NULL after the last. 0 is "air". */
TYPODONT_API const char* typodont_tissue_name(uint32_t tissue);
/* The name of a contact model ("offset", "voxel_penalty" ...) by its index in the list; NULL after the last. */
TYPODONT_API const char* typodont_model_name(uint32_t place);

enum { TYPODONT_TISSUES = 16 }; /* length of every array indexed by tissue; entries of unused numbers stay 0 */

/* The pose of frame B relative to frame A. */
typedef struct typodont_pose {
  double p[3]; /* m, origin of B in A */
  double q[4]; /* unit quaternion w x y z; rotates vectors from B into A */
} typodont_pose;

/* The input of one tick: the hand's pose and pedal. */
typedef struct typodont_sample {
  uint32_t struct_size;
  uint32_t tool;      /* index of the selected tool in the scene's tool list */
  int64_t t_ns;       /* time of the sample; increases from tick to tick */
  typodont_pose X_WT; /* pose of the tool that the hand commands; it may lie inside tissue */
  double pedal;       /* position of the pedal, 0 (released) to 1 */
} typodont_sample;

/* Bits of typodont_tick.faults; docs/safety.md lists the cause of each. */
enum {
  TYPODONT_FAULT_BAD_INPUT = 1,
  TYPODONT_FAULT_STALE_PATCH = 2,
  TYPODONT_FAULT_PATCH_EDGE = 4,
  TYPODONT_FAULT_FORCE_LIMIT = 8,
  TYPODONT_FAULT_DEEP_PENETRATION = 16,
  TYPODONT_FAULT_DEVICE_LOST = 32,
  TYPODONT_FAULT_WEDGED = 64,
  TYPODONT_FAULT_SLEW_LIMIT = 128,
  TYPODONT_FAULT_OVERRUN = 256,
  TYPODONT_FAULT_LET_GO = 512,
  TYPODONT_FAULT_NO_ROOM = 1024,
  TYPODONT_FAULT_HELD = 2048
};

/* The result of one tick of the servo. */
typedef struct typodont_tick {
  uint32_t struct_size;
  uint32_t faults;
  uint64_t index; /* number of earlier ticks */
  int64_t t_ns;
  typodont_pose X_WT;               /* pose of the tool that the hand commands */
  typodont_pose X_WG;               /* pose of the proxy, which stays outside the tissue: draw this one */
  double force[3];                  /* N, force on the hand, frame W */
  double torque[3];                 /* N*m, torque on the hand about the head's centre, frame W */
  double pedal;                     /* position of the pedal, 0 (released) to 1 */
  double depth;                     /* m, distance between the origins of X_WT and X_WG */
  double normal[3];                 /* unit vector out of the tissue; 0 without contact */
  double contact_area;              /* m2, area of the head in contact with tissue */
  double removed[TYPODONT_TISSUES]; /* m3, removed since the start, by tissue */
  double spindle;                   /* rad/s, rotation speed of the spindle */
  double cutting_power;             /* W, power that cutting takes */
  double energy;                    /* J, total energy received from the hand: the passivity observer */
  double spindle_energy;            /* J, total energy that the bur's blades gave to the hand */
  double model_force[3]; /* N, force of the contact model, before the limits and the passivity control reduce it */
  uint64_t cuts;         /* number of cuts until now */
  int64_t cpu_ns;        /* thread CPU time of the tick; 0 if not measured */
  uint32_t tissue;       /* tissue with the largest contact area */
  uint32_t tool;         /* index of the tool in the hand, in the scene's tool list */
  uint32_t level;        /* level of detail of the contact model; 0: the finest */
  uint32_t patch;        /* number of the tissue copy (patch) with which this tick was computed */
  double wear;           /* at equal power, the tool in the hand removes 1 + wear times less than a new one */
} typodont_tick;

/* One cut: the head's motion from pose A to pose B removed tissue (fill_radius 0) or added filling. */
typedef struct typodont_cut {
  uint32_t struct_size;
  uint32_t tool;
  uint64_t index; /* 1, 2, 3 ...; 0: no cut in this tick */
  uint64_t tick;  /* index of the tick that made the cut */
  int64_t t_ns;
  typodont_pose X_WA, X_WB;
  double removed[TYPODONT_TISSUES]; /* m3, removed volume by tissue; negative for added filling */
  double normal[3];
  double spindle;     /* rad/s, rotation speed of the spindle */
  double fill_radius; /* m, radius of the added ball of filling; 0: tissue was removed */
} typodont_cut;

typedef struct typodont_scene typodont_scene;
typedef struct typodont_hand typodont_hand;
typedef struct typodont_core typodont_core;
typedef struct typodont_servo typodont_servo;
typedef struct typodont_session typodont_session;

/* --- Scenes ---------------------------------------------------------------------------------------------------- */

/* Opens a scene file or a shipped scene by its name ("molar-caries"). With `model` NULL the scene selects the contact
 * model. */
TYPODONT_API typodont_result typodont_scene_open(const char* scene, const char* model, typodont_scene** out);
/* Does the same with JSON text. Relative file names refer to `folder` (NULL: the working folder), then to the assets.
 */
TYPODONT_API typodont_result typodont_scene_parse(const char* json, const char* folder, const char* model,
                                                  typodont_scene** out);
/* Returns the complete scene as JSON. The text is valid until the scene is freed. */
TYPODONT_API typodont_result typodont_scene_text(typodont_scene* scene, const char** json);
/* Return the name of the tool at this index (TYPODONT_END after the last) and the name of the contact model. The texts
 * are valid until the scene is freed. */
TYPODONT_API typodont_result typodont_scene_tool(typodont_scene* scene, uint32_t place, const char** name);
TYPODONT_API typodont_result typodont_scene_model(typodont_scene* scene, const char** name);
/* Frees the scene; its cores and hands remain valid. NULL is allowed, here and in all _free functions. */
TYPODONT_API typodont_result typodont_scene_free(typodont_scene* scene);

/* --- Hands that move without a device -------------------------------------------------------------------------- */

/* One row of a path: a pose at a time. Between rows, the pose is interpolated; before the first and after the last row
 * it is constant. */
typedef struct typodont_hand_row {
  uint32_t struct_size;
  uint32_t tool;
  double t; /* s, at least 0, increasing from row to row */
  typodont_pose X_WT;
  double pedal;
  double push[3]; /* N, the push of a simulated hand */
} typodont_hand_row;

/* The simulated hand is a mass on a spring and damper: m*a = K (x_path - x) + b (v_path - v) + push + force. */
typedef struct typodont_hand_model {
  uint32_t struct_size;
  uint32_t reserved;
  double mass;         /* kg, mass m */
  double damping;      /* N*s/m, damping b */
  double stiffness[3]; /* N/m, stiffness K along each axis */
  double push[3];      /* N, push in addition to the spring */
} typodont_hand_model;

/* Opens HAND.csv, HAND.json or "replay:SESSION.h5" as a hand with `rate` Hz. The scene supplies the tools' names. */
TYPODONT_API typodont_result typodont_hand_open(typodont_scene* scene, const char* address, double rate,
                                                typodont_hand** out);
/* Creates a hand from a path of `count` rows. With `model` NULL the hand follows the path exactly and ignores the
 * force.
 */
TYPODONT_API typodont_result typodont_hand_path(const typodont_hand_row* rows, size_t count, double rate,
                                                const typodont_hand_model* model, typodont_hand** out);
/* Returns the next sample; TYPODONT_END after the last. */
TYPODONT_API typodont_result typodont_hand_read(typodont_hand* hand, typodont_sample* out);
/* Sets the force (N) and the torque (N*m) on the hand until the next sample: 3 numbers each, frame W. */
TYPODONT_API typodont_result typodont_hand_write(typodont_hand* hand, const double* force, const double* torque);
TYPODONT_API typodont_result typodont_hand_free(typodont_hand* hand);

/* --- The haptic core: servo and tissue ------------------------------------------------------------------------- */

typedef struct typodont_core_options {
  uint32_t struct_size;
  uint32_t no_torque;    /* 1: the device cannot render a torque; the energy balance then ignores the torque */
  double rate;           /* Hz, nominal rate of the ticks; 0: 1000 */
  double position_step;  /* m, position resolution of the device's encoders; 0: continuous */
  double vibration_band; /* Hz, largest vibration frequency that the device renders; 0: none */
} typodont_core_options;

/* Creates a core and loads the tissue. If `hand` is given, the hand supplies the options, and `options` must be NULL.
 */
TYPODONT_API typodont_result typodont_core_new(typodont_scene* scene, typodont_hand* hand,
                                               const typodont_core_options* options, typodont_core** out);
TYPODONT_API typodont_result typodont_core_free(typodont_core* core);

/* Computes one tick on this thread: first the servo, then the tissue. Equal samples: bit-identical ticks. `cut` may be
 * NULL. The function allocates. If the pose or the pedal contains a value that is not a number, the quaternion is no
 * unit quaternion, or the time is negative, before that of the last tick or more than a day, the result is
 * TYPODONT_BAD_INPUT: the tick has zero force, and `out` is filled. */
TYPODONT_API typodont_result typodont_core_tick(typodont_core* core, const typodont_sample* sample, typodont_tick* out,
                                                typodont_cut* cut);
/* Computes up to `capacity` ticks with the samples of the hand and writes them to `ticks` (NULL: to nowhere). At the
 * end of the hand the result is TYPODONT_END, and `count` is filled. */
TYPODONT_API typodont_result typodont_core_run(typodont_core* core, typodont_hand* hand, typodont_tick* ticks,
                                               size_t capacity, size_t* count);

/* Splits the core over two threads; call this before the first tick. Afterwards a real-time thread calls
 * typodont_servo_tick, and the core's thread calls typodont_core_carve at least every 5 ms. `start_W` (3 numbers, m) is
 * the tool's initial position. The servo and the core may be freed in any order. */
TYPODONT_API typodont_result typodont_core_servo(typodont_core* core, const double* start_W, typodont_servo** out);
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_servo_tick(typodont_servo* servo, const typodont_sample* sample,
                                                                   typodont_tick* out, typodont_cut* cut);
/* Repeats the servo's cuts on the tissue and sends new patches (copies of the tissue around the tool) to the servo.
 * `worked` (may be NULL) is 1 if the call had work to do; if it is 0, the thread may sleep for a third of a
 * millisecond. */
TYPODONT_API typodont_result typodont_core_carve(typodont_core* core, int32_t* worked);
TYPODONT_API typodont_result typodont_servo_free(typodont_servo* servo);

/* Reverts the last stroke, or restores it. `done` (may be NULL) is 0 if there is no such stroke. */
TYPODONT_API typodont_result typodont_core_undo(typodont_core* core, int32_t* done);
TYPODONT_API typodont_result typodont_core_redo(typodont_core* core, int32_t* done);

/* One vertex of the surface: 28 bytes, suitable for a vertex buffer. */
typedef struct typodont_vertex {
  float position[3]; /* m, frame W */
  float normal[3];   /* unit normal, pointing out of the tissue */
  uint8_t tissue[2]; /* the two tissues of this triangle, equal at its three vertices */
  uint8_t second;    /* 0..255: fraction of tissue[1] at this vertex */
  uint8_t reserved;
} typodont_vertex;

/* The triangles of one brick (block of 16^3 cells) of the tissue's surface. If a part has no indices, the brick has no
 * surface now. */
typedef struct typodont_mesh_part {
  int32_t brick[3];
  uint32_t vertex_count;
  uint32_t index_count; /* three per triangle, counter-clockwise seen from outside */
  uint32_t reserved;
  const typodont_vertex* vertices;
  const uint32_t* indices;
} typodont_mesh_part;

/* The first call returns all parts of the surface, each later call the parts that changed since the previous call.
 * `parts` and their arrays are valid until the next call for this core, or until the core is freed. */
TYPODONT_API typodont_result typodont_core_mesh(typodont_core* core, const typodont_mesh_part** parts, size_t* count);

/* Describes the distance field: per voxel the signed distance to the surface, negative inside, and a tissue label. */
typedef struct typodont_field {
  uint32_t struct_size;
  uint32_t reserved;
  double origin[3];  /* m, frame W, position of voxel (0, 0, 0) */
  double voxel;      /* m, edge of a voxel */
  double band;       /* m, distance from the surface up to which distances are stored */
  int32_t low[3];    /* lowest voxel near the surface; low > high: there is no surface */
  int32_t high[3];   /* highest voxel near the surface, inclusive */
  uint64_t elements; /* number of voxels, spheres or vertices in the contact model's tissue */
} typodont_field;
TYPODONT_API typodont_result typodont_core_field(typodont_core* core, typodont_field* out);
/* Returns distance (m) and tissue at `count` points (3 numbers each, m, frame W). Each output may be NULL. Points
 * outside the field give air. */
TYPODONT_API typodont_result typodont_core_query(typodont_core* core, const double* points, size_t count,
                                                 double* distance, uint8_t* tissue);
/* Copies a box of voxels with the corner `low`: distances in m, labels. z is the fastest index. Each output may be
 * NULL. */
TYPODONT_API typodont_result typodont_core_copy(typodont_core* core, const int32_t* low, const int32_t* size,
                                                float* distance, uint8_t* tissue);
/* Returns the volume of each tissue in m3: TYPODONT_TISSUES numbers. */
TYPODONT_API typodont_result typodont_core_volumes(typodont_core* core, double* volumes);
/* Returns a hash of all tissue. Equal fields have equal hashes. */
TYPODONT_API typodont_result typodont_core_hash(typodont_core* core, uint64_t* hash);
/* Writes the tissue as a volume file (.vdb). A failed call leaves no partial file. */
TYPODONT_API typodont_result typodont_core_save(typodont_core* core, const char* file);

/* Starts the recording of a session (.h5), which `typodont replay --check` repeats; call this before the first tick.
 * typodont_core_finish creates the file; without that call there is no file. */
TYPODONT_API typodont_result typodont_core_record(typodont_core* core, const char* file, const char* trainee);
TYPODONT_API typodont_result typodont_core_finish(typodont_core* core);

/* --- Recorded sessions ----------------------------------------------------------------------------------------- */

typedef struct typodont_session_info {
  uint32_t struct_size;
  uint32_t truncated; /* 1: the recording ended early; the file contains its first part */
  uint64_t ticks, cuts, events;
  double rate;                             /* Hz, rate of the ticks */
  double volumes_before[TYPODONT_TISSUES]; /* m3 of each tissue at the start */
  double volumes_after[TYPODONT_TISSUES];  /* m3 of each tissue at the end; NaN if not known */
} typodont_session_info;

TYPODONT_API typodont_result typodont_session_open(const char* file, typodont_session** out);
TYPODONT_API typodont_result typodont_session_free(typodont_session* session);
TYPODONT_API typodont_result typodont_session_info_of(typodont_session* session, typodont_session_info* out);
/* Returns one text of the session; `what` is "scene", "rig" (JSON), "hand", "trainee", "model", "date" or "version".
 * The text is valid until the session is freed. */
TYPODONT_API typodont_result typodont_session_text(typodont_session* session, const char* what, const char** text);
/* Read up to `count` rows from row `first` on; `read` receives their number. */
TYPODONT_API typodont_result typodont_session_ticks(typodont_session* session, uint64_t first, typodont_tick* ticks,
                                                    size_t count, size_t* read);
TYPODONT_API typodont_result typodont_session_cuts(typodont_session* session, uint64_t first, typodont_cut* cuts,
                                                   size_t count, size_t* read);
/* One event, for example a tool change or the start of a fault. The texts are valid until the session is freed. */
typedef struct typodont_event {
  uint32_t struct_size;
  uint32_t reserved;
  int64_t t_ns;
  const char* kind; /* "tool", "fault", "undo" ...: docs/session_format.md */
  const char* text;
} typodont_event;
TYPODONT_API typodont_result typodont_session_event(typodont_session* session, uint64_t place, typodont_event* out);

#ifdef __cplusplus
}
#endif
#endif
