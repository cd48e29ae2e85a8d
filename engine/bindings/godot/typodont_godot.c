/* Typodont in Godot 3: the NativeScript class TypodontTooth, based on the C interface. Lengths in mm, so that a tooth
 * is ten units large; forces in N. All methods may be called from the scene's thread. On failure, methods with a String
 * return the reason, otherwise "".
 *
 *   open(scene) -> String                          opens a scene: a file, a shipped scene's name or JSON
 *   tick(t, position, rotation, pedal) -> Vector3  computes one step on this thread; returns the force on the hand
 *   start(position) -> String                      instead of tick(): starts the servo's own thread, 1 kHz
 *   hand(position, rotation, pedal) -> Vector3     with start(): sets the hand's pose; returns the newest force
 *   carve() -> String                              with start(), call each frame: updates the tissue
 *   tool() -> Vector3                              position at which to draw the tool (outside the tissue)
 *   removed() -> float                             mm³, removed volume of all tissues together
 *   mesh() -> Array                                changed mesh bricks; for each: key, vertices, normals, indices
 *   undo() -> bool                                 undoes the last stroke; false: none was undone
 *   error() -> String                              message of the last failed call
 */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <typodont.h>

#include "gdnative.h"

static const gd_core* gd;

typedef struct {
  typodont_core* core;
  typodont_servo* servo; /* null unless `thread` runs */
  pthread_t thread;
  atomic_bool going;
  pthread_mutex_t mutex;  /* protects `sample` and `tick` */
  typodont_sample sample; /* pose and pedal, as the scene last set them */
  typodont_tick tick;     /* newest tick */
  char error[512];
} Tooth;

static void keep_error(Tooth* tooth) {
  strncpy(tooth->error, typodont_error(), sizeof tooth->error - 1);
}

/* --- Values of the engine --- */

static gd_variant text(const char* utf8) {
  gd_handle string;
  gd_variant v;
  gd_string_new(gd, &string);
  gd_string_parse_utf8(gd, &string, utf8);
  gd_variant_string(gd, &v, &string);
  gd_string_destroy(gd, &string);
  return v;
}
static gd_variant vector(const double* v, double scale) {
  const gd_vector3 p = {(float)(v[0] * scale), (float)(v[1] * scale), (float)(v[2] * scale)};
  gd_variant out;
  gd_variant_vector3(gd, &out, &p);
  return out;
}
static void to_position(const gd_variant* v, double* p) {
  const gd_vector3_bytes bytes = gd_as_vector3(gd, v);
  gd_vector3 f;
  memcpy(&f, &bytes, sizeof f);
  p[0] = f.x * 1e-3, p[1] = f.y * 1e-3, p[2] = f.z * 1e-3;
}
static void to_pose(gd_variant** position_and_rotation, typodont_pose* X) {
  to_position(position_and_rotation[0], X->p);
  const gd_quat_bytes bytes = gd_as_quat(gd, position_and_rotation[1]);
  float q[4]; /* x y z w */
  memcpy(q, &bytes, sizeof q);
  X->q[0] = q[3], X->q[1] = q[0], X->q[2] = q[1], X->q[3] = q[2];
}

/* --- The servo's thread --- */

/* Moves X towards `to` by one tick of 1 ms, and returns it. An invalid `to` is returned as it is, and leaves X
 * unchanged. The scene sets the pose once per frame: without smoothing, the energy ledger would reduce the force after
 * each jump (docs/passivity.md). */
static typodont_pose follow(typodont_pose* X, const typodont_pose* to) {
  const double share = 1 - exp(-1e-3 / 20e-3); /* time constant: 20 ms */
  typodont_pose next;
  double turn = 0, size = 0; /* cosine between the quaternions; squared size of the new one */
  for (int i = 0; i < 4; ++i) turn += X->q[i] * to->q[i];
  for (int i = 0; i < 3; ++i) next.p[i] = X->p[i] + share * (to->p[i] - X->p[i]);
  for (int i = 0; i < 4; ++i) {
    next.q[i] = X->q[i] + share * ((turn < 0 ? -1 : 1) * to->q[i] - X->q[i]);
    size += next.q[i] * next.q[i];
  }
  for (int i = 0; i < 4; ++i) next.q[i] /= sqrt(size);
  if (!isfinite(next.p[0] + next.p[1] + next.p[2] + size)) return *to;
  return *X = next;
}

static void* feel(void* user) {
  Tooth* const tooth = user;
  typodont_sample sample;
  typodont_pose X = tooth->sample.X_WT;
  typodont_tick tick = {.struct_size = sizeof tick};
  struct timespec next;
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (int64_t t = 0; tooth->going; t += 1000000) {
    pthread_mutex_lock(&tooth->mutex);
    sample = tooth->sample;
    pthread_mutex_unlock(&tooth->mutex);
    sample.t_ns = t;
    sample.X_WT = follow(&X, &sample.X_WT);
    typodont_servo_tick(tooth->servo, &sample, &tick, NULL); /* invalid pose: zero force, a bit in tick.faults */
    pthread_mutex_lock(&tooth->mutex);
    tooth->tick = tick;
    pthread_mutex_unlock(&tooth->mutex);
    next.tv_nsec += 1000000;
    if (next.tv_nsec >= 1000000000) next.tv_nsec -= 1000000000, ++next.tv_sec;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
  }
  return NULL;
}

static void stop(Tooth* tooth) {
  if (tooth->servo) {
    tooth->going = false;
    pthread_join(tooth->thread, NULL);
    typodont_servo_free(tooth->servo);
    tooth->servo = NULL;
  }
  typodont_core_free(tooth->core);
  tooth->core = NULL;
}

/* --- Methods --- */

#define METHOD(name, count)                                                                     \
  static gd_variant name(gd_object* self, void* data, void* user, int given, gd_variant** in) { \
    Tooth* const tooth = user;                                                                  \
    (void)self, (void)data, (void)tooth, (void)in;                                              \
    if (given != (count)) return text(#name ": another number of arguments");

METHOD(open_scene, 1)
  stop(tooth);
  gd_handle name = gd_as_string(gd, in[0]), bytes = gd_string_utf8(gd, &name);
  const char* const scene_text = gd_chars(gd, &bytes);
  typodont_scene* scene = NULL;
  const typodont_result result = *scene_text == '{' ? typodont_scene_parse(scene_text, NULL, NULL, &scene)
                                                    : typodont_scene_open(scene_text, NULL, &scene);
  gd_chars_destroy(gd, &bytes);
  gd_string_destroy(gd, &name);
  if (result || typodont_core_new(scene, NULL, NULL, &tooth->core)) {
    keep_error(tooth);
    typodont_scene_free(scene);
    return text(tooth->error);
  }
  typodont_scene_free(scene);
  return text("");
}

METHOD(tick, 4)
  typodont_sample sample = {.struct_size = sizeof sample, .t_ns = (int64_t)(gd_as_real(gd, in[0]) * 1e9)};
  to_pose(in + 1, &sample.X_WT);
  sample.pedal = gd_as_real(gd, in[3]);
  if (typodont_core_tick(tooth->core, &sample, &tooth->tick, NULL)) {
    keep_error(tooth);
    const double none[3] = {0, 0, 0};
    return vector(none, 1);
  }
  return vector(tooth->tick.force, 1);
}

METHOD(start, 1)
  to_position(in[0], tooth->sample.X_WT.p);
  if (typodont_core_servo(tooth->core, tooth->sample.X_WT.p, &tooth->servo)) {
    keep_error(tooth);
    return text(tooth->error);
  }
  tooth->going = true;
  if (pthread_create(&tooth->thread, NULL, feel, tooth)) {
    typodont_servo_free(tooth->servo);
    tooth->servo = NULL;
    return text("no thread for the servo");
  }
  return text("");
}

METHOD(hand, 3)
  typodont_pose X;
  to_pose(in, &X);
  pthread_mutex_lock(&tooth->mutex);
  tooth->sample.X_WT = X;
  tooth->sample.pedal = gd_as_real(gd, in[2]);
  const gd_variant force = vector(tooth->tick.force, 1);
  pthread_mutex_unlock(&tooth->mutex);
  return force;
}

METHOD(carve, 0)
  if (typodont_core_carve(tooth->core, NULL)) {
    keep_error(tooth);
    return text(tooth->error);
  }
  return text("");
}

METHOD(tool, 0)
  pthread_mutex_lock(&tooth->mutex);
  const gd_variant at = vector(tooth->tick.X_WG.p, 1e3);
  pthread_mutex_unlock(&tooth->mutex);
  return at;
}

METHOD(removed, 0)
  double sum = 0;
  pthread_mutex_lock(&tooth->mutex);
  for (int i = 0; i < TYPODONT_TISSUES; ++i) sum += tooth->tick.removed[i];
  pthread_mutex_unlock(&tooth->mutex);
  gd_variant v;
  gd_variant_real(gd, &v, sum * 1e9);
  return v;
}

METHOD(undo, 0)
  int32_t done = 0;
  if (typodont_core_undo(tooth->core, &done)) keep_error(tooth);
  gd_variant v;
  gd_variant_bool(gd, &v, done != 0);
  return v;
}

METHOD(error, 0)
  return text(tooth->error);
}

/* Array of the vertices' positions (offset 0) or normals (offset 3), times `scale`. */
static gd_variant corners(const typodont_mesh_part* part, int offset, float scale) {
  gd_handle array;
  gd_vector3_array_new(gd, &array);
  gd_vector3_array_resize(gd, &array, (int)part->vertex_count);
  void* const access = gd_vector3_array_write(gd, &array);
  gd_vector3* const to = gd_vector3_access(gd, access);
  for (uint32_t i = 0; i < part->vertex_count; ++i) {
    const float* const from = offset ? part->vertices[i].normal : part->vertices[i].position;
    to[i].x = from[0] * scale, to[i].y = from[1] * scale, to[i].z = from[2] * scale;
  }
  gd_vector3_access_destroy(gd, access);
  gd_variant v;
  gd_variant_vector3_array(gd, &v, &array);
  gd_vector3_array_destroy(gd, &array);
  return v;
}
/* Godot draws triangles that are clockwise from outside. */
static gd_variant triangles(const typodont_mesh_part* part) {
  gd_handle array;
  gd_int_array_new(gd, &array);
  gd_int_array_resize(gd, &array, (int)part->index_count);
  void* const access = gd_int_array_write(gd, &array);
  int* const to = gd_int_access(gd, access);
  for (uint32_t i = 0; i < part->index_count; i += 3) {
    to[i] = (int)part->indices[i], to[i + 1] = (int)part->indices[i + 2], to[i + 2] = (int)part->indices[i + 1];
  }
  gd_int_access_destroy(gd, access);
  gd_variant v;
  gd_variant_int_array(gd, &v, &array);
  gd_int_array_destroy(gd, &array);
  return v;
}

METHOD(mesh, 0)
  const typodont_mesh_part* parts = NULL;
  size_t count = 0;
  if (typodont_core_mesh(tooth->core, &parts, &count)) keep_error(tooth), count = 0;
  gd_handle array;
  gd_array_new(gd, &array);
  for (size_t i = 0; i < count; ++i) {
    const double key[3] = {parts[i].brick[0], parts[i].brick[1], parts[i].brick[2]};
    gd_variant values[] = {vector(key, 1), corners(&parts[i], 0, 1e3f), corners(&parts[i], 3, 1), triangles(&parts[i])};
    for (int k = 0; k < 4; ++k) {
      gd_array_append(gd, &array, &values[k]);
      gd_variant_destroy(gd, &values[k]);
    }
  }
  gd_variant v;
  gd_variant_array(gd, &v, &array);
  gd_array_destroy(gd, &array);
  return v;
}

static void* create(gd_object* self, void* data) {
  (void)self, (void)data;
  Tooth* const tooth = calloc(1, sizeof *tooth);
  tooth->sample.struct_size = sizeof tooth->sample;
  tooth->sample.X_WT.q[0] = 1;
  tooth->tick.struct_size = sizeof tooth->tick;
  pthread_mutex_init(&tooth->mutex, NULL);
  return tooth;
}
static void destroy(gd_object* self, void* data, void* user) {
  (void)self, (void)data;
  Tooth* const tooth = user;
  stop(tooth);
  pthread_mutex_destroy(&tooth->mutex);
  free(tooth);
}

#define EXPORT __attribute__((visibility("default")))

EXPORT void godot_gdnative_init(gd_init_options* options) {
  gd = options->core;
}
EXPORT void godot_gdnative_terminate(void* options) {
  (void)options;
  gd = NULL;
}
EXPORT void godot_nativescript_init(void* handle) {
  const gd_nativescript* script = NULL;
  for (unsigned i = 0; i < gd->extension_count; ++i) {
    if (gd->extensions[i]->type == GD_NATIVESCRIPT) script = (const gd_nativescript*)gd->extensions[i];
  }
  if (!script) return;
  const gd_create made = {create, NULL, NULL};
  const gd_destroy gone = {destroy, NULL, NULL};
  script->register_class(handle, "TypodontTooth", "Reference", made, gone);
  const struct {
    const char* name;
    gd_variant (*method)(gd_object*, void*, void*, int, gd_variant**);
  } methods[] = {{"open", open_scene}, {"tick", tick}, {"start", start},     {"hand", hand}, {"carve", carve}, {"tool", tool},
                 {"removed", removed}, {"mesh", mesh}, {"undo", undo}, {"error", error}};
  for (size_t i = 0; i < sizeof methods / sizeof *methods; ++i) {
    const gd_attributes attributes = {0};
    const gd_method method = {methods[i].method, NULL, NULL};
    script->register_method(handle, "TypodontTooth", methods[i].name, attributes, method);
  }
}
