/* Typodont as a library for C and for every language that can call C: scenes, hands, the haptic core, recorded
 * sessions. Sound is in typodont_sound.h, calibration in typodont_calibration.h; one library, libtypodont.so, has them
 * all.
 *
 *   typodont_scene* scene; typodont_core* core;
 *   typodont_scene_open("molar-caries", NULL, &scene);
 *   typodont_core_new(scene, NULL, NULL, &core);
 *   typodont_sample hand = {sizeof hand}; typodont_tick tick = {sizeof tick};
 *   ... each millisecond: fill `hand`, typodont_core_tick(core, &hand, &tick, NULL), give tick.force to the hand ...
 *
 * Units are SI: m, N, N*m, s, rad, J, W. W is the workbench frame, T the tool: its origin is the centre of the head,
 * its z axis points along the shank. Times are nanoseconds since the session's start. Quaternions are w, x, y, z.
 *
 * Results: every function that can fail returns a typodont_result. typodont_error() then says why, in this thread.
 * Nothing is written through the output pointers of a call that failed, unless the function says otherwise.
 *
 * Handles: a handle is a number in the guise of a pointer and is never dereferenced. NULL, a handle of another kind and
 * one that was freed give TYPODONT_BAD_HANDLE. Each handle serves one thread at a time: a second thread that comes
 * while the first is inside gets TYPODONT_BUSY, and nothing happens. Different handles are independent of each other.
 *
 * Threads: functions may be called from any thread. TYPODONT_REALTIME marks those that never allocate, lock or wait;
 * they may be called from a real-time thread. All others are for set-up and for ordinary threads.
 *
 * Structs begin with `struct_size`, which the caller sets to sizeof of the struct. Later versions add members at the
 * end only. Arrays of structs are as far apart as the first element's struct_size says; of the structs that the library
 * fills in an array, only the first needs it set.
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
  TYPODONT_FAILED = 1,     /* the run failed although its input was good: a full disk, a late thread */
  TYPODONT_BAD_INPUT = 2,  /* an argument, a file or a pose that cannot be used */
  TYPODONT_BAD_HANDLE = 3, /* NULL, freed, or of another kind */
  TYPODONT_BUSY = 4,       /* another thread is using this handle */
  TYPODONT_END = 5,        /* there is nothing more to read */
  TYPODONT_NO_MEMORY = 6
};

/* Static text. */
TYPODONT_API const char* typodont_version(void);
/* Why the last call of this thread that did not return TYPODONT_OK failed. Valid until this thread's next call. */
TYPODONT_REALTIME TYPODONT_API const char* typodont_error(void);
/* "enamel" of its number; NULL after the last. Static text. 0 is "air". */
TYPODONT_API const char* typodont_tissue_name(uint32_t tissue);
/* "offset", "voxel_penalty" ...: the contact models by their place; NULL after the last. */
TYPODONT_API const char* typodont_model_name(uint32_t place);

enum { TYPODONT_TISSUES = 16 }; /* room in every array by tissue; numbers without a name stay 0 */

/* Where frame B is, seen from frame A. */
typedef struct typodont_pose {
  double p[3]; /* m */
  double q[4]; /* unit quaternion, w x y z, turns vectors from B into A */
} typodont_pose;

/* The hand at one tick. */
typedef struct typodont_sample {
  uint32_t struct_size;
  uint32_t tool;      /* place in the scene's tray that is wanted */
  int64_t t_ns;       /* when it was sampled; rises from tick to tick */
  typodont_pose X_WT; /* the tool where the hand holds it */
  double pedal;       /* 0..1 */
} typodont_sample;

/* Bits of typodont_tick.faults; docs/safety.md says what sets each. */
enum {
  TYPODONT_FAULT_BAD_INPUT = 1,
  TYPODONT_FAULT_STALE_PATCH = 2,
  TYPODONT_FAULT_PATCH_EDGE = 4,
  TYPODONT_FAULT_FORCE_LIMIT = 8,
  TYPODONT_FAULT_DEEP_PENETRATION = 16,
  TYPODONT_FAULT_DEVICE_LOST = 32,
  TYPODONT_FAULT_RING_FULL = 64,
  TYPODONT_FAULT_SLEW_LIMIT = 128,
  TYPODONT_FAULT_OVERRUN = 256,
  TYPODONT_FAULT_LET_GO = 512,
  TYPODONT_FAULT_NO_ROOM = 1024,
  TYPODONT_FAULT_HELD = 2048,
  TYPODONT_FAULT_WEDGED = 4096
};

/* What the servo answers. */
typedef struct typodont_tick {
  uint32_t struct_size;
  uint32_t faults;
  uint64_t index; /* ticks before this one */
  int64_t t_ns;
  typodont_pose X_WT;               /* the tool where the hand holds it */
  typodont_pose X_WG;               /* the tool as held outside the tissue: draw this one */
  double force[3];                  /* N, on the hand, W */
  double torque[3];                 /* N*m, on the hand about the head's centre, W */
  double pedal;                     /* 0..1 */
  double depth;                     /* m between the two poses */
  double normal[3];                 /* unit, out of the tissue; 0 when free */
  double contact_area;              /* m2 */
  double removed[TYPODONT_TISSUES]; /* m3 since the start, by tissue */
  double spindle;                   /* rad/s */
  double cutting_power;             /* W */
  double energy;                    /* J taken from the hand so far: the passivity observer */
  double spindle_energy;            /* J given to the hand by the teeth */
  double model_force[3];            /* N, of the contact model, before limits and ledger */
  uint64_t cuts;                    /* made so far */
  int64_t cpu_ns;                   /* thread CPU time of the tick; 0 where not measured */
  uint32_t tissue;                  /* that the head touches most */
  uint32_t tool;                    /* in the hand */
  uint32_t level;                   /* of detail; 0: the finest */
  uint32_t patch;                   /* number of the surface patch that was used */
} typodont_tick;

/* The head swept from A to B took tissue away (fill_radius 0), or filling was put down. */
typedef struct typodont_cut {
  uint32_t struct_size;
  uint32_t tool;
  uint64_t index; /* 1, 2, 3 ...; 0: this tick cut nothing */
  uint64_t tick;  /* that made it */
  int64_t t_ns;
  typodont_pose X_WA, X_WB;
  double removed[TYPODONT_TISSUES]; /* m3; negative where filled */
  double normal[3];
  double spindle;     /* rad/s */
  double fill_radius; /* m */
} typodont_cut;

typedef struct typodont_scene typodont_scene;
typedef struct typodont_hand typodont_hand;
typedef struct typodont_core typodont_core;
typedef struct typodont_servo typodont_servo;
typedef struct typodont_session typodont_session;

/* --- Scenes ---------------------------------------------------------------------------------------------------- */

/* A scene file, or the name of a shipped one ("molar-caries"). `model` NULL: as the scene says. */
TYPODONT_API typodont_result typodont_scene_open(const char* scene, const char* model, typodont_scene** out);
/* The same from JSON. Its files are looked for in `folder` (NULL: the working folder), then among the assets. */
TYPODONT_API typodont_result typodont_scene_parse(const char* json, const char* folder, const char* model,
                                                  typodont_scene** out);
/* The scene in full, as JSON. Valid until the scene is freed. */
TYPODONT_API typodont_result typodont_scene_text(typodont_scene* scene, const char** json);
/* Name of the tool at this place of the tray (TYPODONT_END after the last); of the contact model. Valid as above. */
TYPODONT_API typodont_result typodont_scene_tool(typodont_scene* scene, uint32_t place, const char** name);
TYPODONT_API typodont_result typodont_scene_model(typodont_scene* scene, const char** name);
/* Cores and hands that were made from it go on without it. NULL is allowed, here and in all _free functions. */
TYPODONT_API typodont_result typodont_scene_free(typodont_scene* scene);

/* --- Hands: what moves by itself, without a device ------------------------------------------------------------- */

/* A row of a path. Between rows it is interpolated; before the first and after the last the pose stays. */
typedef struct typodont_hand_row {
  uint32_t struct_size;
  uint32_t tool;
  double t; /* s, rising from row to row, 0 or more */
  typodont_pose X_WT;
  double pedal;
  double push[3]; /* N, of a simulated hand */
} typodont_hand_row;

/* m*a = K (x_path - x) + b (v_path - v) + push + force */
typedef struct typodont_hand_model {
  uint32_t struct_size;
  uint32_t reserved;
  double mass;         /* kg */
  double damping;      /* N*s/m */
  double stiffness[3]; /* N/m */
  double push[3];      /* N */
} typodont_hand_model;

/* HAND.csv, HAND.json or "replay:SESSION.h5", at `rate` Hz. The scene tells what its tools are called. */
TYPODONT_API typodont_result typodont_hand_open(typodont_scene* scene, const char* address, double rate,
                                                typodont_hand** out);
/* A path of `count` rows. `model` NULL: the hand follows it exactly, whatever the force. */
TYPODONT_API typodont_result typodont_hand_path(const typodont_hand_row* rows, size_t count, double rate,
                                                const typodont_hand_model* model, typodont_hand** out);
/* The next sample; TYPODONT_END after the last. */
TYPODONT_API typodont_result typodont_hand_read(typodont_hand* hand, typodont_sample* out);
/* What the hand feels until the next sample: 3 numbers each, N and N*m, W. */
TYPODONT_API typodont_result typodont_hand_write(typodont_hand* hand, const double* force, const double* torque);
TYPODONT_API typodont_result typodont_hand_free(typodont_hand* hand);

/* --- The haptic core: servo and tissue ------------------------------------------------------------------------- */

typedef struct typodont_core_options {
  uint32_t struct_size;
  uint32_t no_torque;    /* 1: the device resists no turns; its torque is then not in the energy ledger */
  double rate;           /* Hz, nominal; 0: 1000 */
  double position_step;  /* m, of the device's encoders; 0: smooth */
  double vibration_band; /* Hz that the device renders; 0: none */
} typodont_core_options;

/* Loads the tissue. With a hand, rate and options are the hand's and `options` must be NULL. */
TYPODONT_API typodont_result typodont_core_new(typodont_scene* scene, typodont_hand* hand,
                                               const typodont_core_options* options, typodont_core** out);
TYPODONT_API typodont_result typodont_core_free(typodont_core* core);

/* One tick: servo, then tissue, on this thread. The same samples give the same bits. `cut` may be NULL. Allocates.
 * A pose or pedal that is not a number, or no unit quaternion, gives TYPODONT_BAD_INPUT: the tick is done with zero
 * force and `out` is filled. */
TYPODONT_API typodont_result typodont_core_tick(typodont_core* core, const typodont_sample* sample, typodont_tick* out,
                                                typodont_cut* cut);
/* Follows the hand for up to `capacity` ticks, which go to `ticks` (NULL: they are not kept). TYPODONT_END, and `count`
 * filled, when the hand has come to its end. */
TYPODONT_API typodont_result typodont_core_run(typodont_core* core, typodont_hand* hand, typodont_tick* ticks,
                                               size_t capacity, size_t* count);

/* Two threads: before the first tick, the servo is given away to a real-time thread. From then on that thread calls
 * typodont_servo_tick, and the core's thread typodont_core_carve, at least every 5 ms. `start_W` (3 numbers, m) is
 * where the tool is at first. The servo may outlive the core, and the core the servo. */
TYPODONT_API typodont_result typodont_core_servo(typodont_core* core, const double* start_W, typodont_servo** out);
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_servo_tick(typodont_servo* servo, const typodont_sample* sample,
                                                                   typodont_tick* out, typodont_cut* cut);
/* Repeats the servo's cuts on the tissue, and hands fresh surface to it. `worked` (may be NULL): 1 where there was
 * something to do; where there was not, the thread may sleep for a third of a millisecond. */
TYPODONT_API typodont_result typodont_core_carve(typodont_core* core, int32_t* worked);
TYPODONT_API typodont_result typodont_servo_free(typodont_servo* servo);

/* Takes the last stroke back, or brings it again. `done` (may be NULL): 0 where there is none. */
TYPODONT_API typodont_result typodont_core_undo(typodont_core* core, int32_t* done);
TYPODONT_API typodont_result typodont_core_redo(typodont_core* core, int32_t* done);

/* A corner: 28 bytes, as a vertex buffer takes it. */
typedef struct typodont_vertex {
  float position[3]; /* m, W */
  float normal[3];   /* unit, out of the tissue */
  uint8_t tissue[2]; /* the two tissues at this triangle, the same at its three corners */
  uint8_t second;    /* 0..255: share of tissue[1] here */
  uint8_t reserved;
} typodont_vertex;

/* The triangles of one brick of the tissue's surface. A part without indices is gone. */
typedef struct typodont_mesh_part {
  int32_t brick[3];
  uint32_t vertex_count;
  uint32_t index_count; /* three a triangle, counter-clockwise seen from outside */
  uint32_t reserved;
  const typodont_vertex* vertices;
  const uint32_t* indices;
} typodont_mesh_part;

/* All parts of the surface the first time, afterwards those that changed since the last call. `parts` and what they
 * point to are valid until the next call for this core, or until it is freed. */
TYPODONT_API typodont_result typodont_core_mesh(typodont_core* core, const typodont_mesh_part** parts, size_t* count);

/* The field: signed distance to the surface, negative inside, and a tissue label per voxel. */
typedef struct typodont_field {
  uint32_t struct_size;
  uint32_t reserved;
  double origin[3]; /* m, W, of voxel (0, 0, 0) */
  double voxel;     /* m */
  double band;      /* m to which distances are kept */
  int32_t low[3];   /* voxels near the surface, inclusive; low > high: there is none */
  int32_t high[3];
  uint64_t elements; /* voxels, spheres or vertices that the contact model's tissue consists of */
} typodont_field;
TYPODONT_API typodont_result typodont_core_field(typodont_core* core, typodont_field* out);
/* Distance (m) and tissue at `count` points (3 numbers each, m, W). Either output may be NULL. Air outside. */
TYPODONT_API typodont_result typodont_core_query(typodont_core* core, const double* points, size_t count,
                                                 double* distance, uint8_t* tissue);
/* A box of voxels from `low` on, z fastest: distances in m, labels. Either output may be NULL. */
TYPODONT_API typodont_result typodont_core_copy(typodont_core* core, const int32_t* low, const int32_t* size,
                                                float* distance, uint8_t* tissue);
/* m3 of each tissue: TYPODONT_TISSUES numbers. */
TYPODONT_API typodont_result typodont_core_volumes(typodont_core* core, double* volumes);
/* Of all tissue: equal fields, equal hashes. */
TYPODONT_API typodont_result typodont_core_hash(typodont_core* core, uint64_t* hash);
/* Writes the tissue as a volume (.vdb), whole or not at all. */
TYPODONT_API typodont_result typodont_core_save(typodont_core* core, const char* file);

/* Before the first tick: everything from now on is recorded into a session (.h5), which `typodont replay --check`
 * repeats. The file appears when the recording is finished; without that, nothing is left behind. */
TYPODONT_API typodont_result typodont_core_record(typodont_core* core, const char* file, const char* trainee);
TYPODONT_API typodont_result typodont_core_finish(typodont_core* core);

/* --- Recorded sessions ----------------------------------------------------------------------------------------- */

typedef struct typodont_session_info {
  uint32_t struct_size;
  uint32_t truncated; /* 1: the recording was cut off, and is here as far as it goes */
  uint64_t ticks, cuts, events;
  double rate;                             /* Hz */
  double volumes_before[TYPODONT_TISSUES]; /* m3 */
  double volumes_after[TYPODONT_TISSUES];  /* m3; NaN where not known */
} typodont_session_info;

TYPODONT_API typodont_result typodont_session_open(const char* file, typodont_session** out);
TYPODONT_API typodont_result typodont_session_free(typodont_session* session);
TYPODONT_API typodont_result typodont_session_info_of(typodont_session* session, typodont_session_info* out);
/* "scene", "rig" (JSON), "hand", "trainee", "model", "date", "version". Valid until the session is freed. */
TYPODONT_API typodont_result typodont_session_text(typodont_session* session, const char* what, const char** text);
/* Rows from `first` on, up to `count`; `read` says how many there were. */
TYPODONT_API typodont_result typodont_session_ticks(typodont_session* session, uint64_t first, typodont_tick* ticks,
                                                    size_t count, size_t* read);
TYPODONT_API typodont_result typodont_session_cuts(typodont_session* session, uint64_t first, typodont_cut* cuts,
                                                   size_t count, size_t* read);
/* What happened once: a tool was taken up, a fault began. Texts are valid until the session is freed. */
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
