/* random_host SEED CALLS: three threads call random functions of the C interface with random handles, structs, numbers and
 * texts, most of them valid. Handles are shared, so they are used by two threads at once, after they were freed, and as
 * another kind. Every result must be one of the documented ones, and every failure must have a text. */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <typodont.h>
#include <typodont_calibration.h>
#include <typodont_sound.h>

enum { kThreads = 3, kPool = 24, kLargest = 4096, kCount = 8, kFunctions = 36 };

static const char* const kScene =
    "{\"tissue\": {\"voxel_mm\": 0.4, \"solids\": [{\"tissue\": \"enamel\", \"solid\": {\"sphere\": {\"radius_mm\": 1.5}}}]},"
    " \"tool\": \"round_012\", \"spindle_krpm\": 300}";

static _Atomic(uintptr_t) pool[kPool]; /* handles of all kinds, also freed ones */
static atomic_long failures, results[TYPODONT_NO_MEMORY + 1];
static long calls;

typedef struct {
  uint64_t state;
  int number;
  char file[32];
  _Alignas(16) char out[kCount * kLargest]; /* larger than whatever a call may write */
} Host;

static uint32_t below(Host* h, uint32_t n) { /* xorshift64* */
  h->state ^= h->state >> 12, h->state ^= h->state << 25, h->state ^= h->state >> 27;
  return (uint32_t)((h->state * 2685821657736338717ull) >> 33) % n;
}
static int rarely(Host* h) { return below(h, 12) == 0; }

static double number(Host* h, double scale) {
  static const double odd[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e-300, 0, -0.0, -1};
  return rarely(h) ? odd[below(h, sizeof odd / sizeof *odd)] : scale * (below(h, 2001) / 1000.0 - 1);
}
static uint32_t size_of(Host* h, size_t right) {
  static const uint32_t odd[] = {0, 4, 7, 8, 16, 4096, 4104, 1u << 31, UINT32_MAX};
  return rarely(h) ? odd[below(h, sizeof odd / sizeof *odd)] : (uint32_t)right;
}
static void* handle(Host* h) {
  static char no_handle;
  if (rarely(h)) return below(h, 2) ? NULL : (void*)&no_handle;
  return (void*)atomic_load(&pool[below(h, kPool)]);
}
static void keep(Host* h, void* made) {
  if (made) atomic_store(&pool[below(h, kPool)], (uintptr_t)made);
}
static const char* text(Host* h, const char* right) {
  static const char* const odd[] = {NULL, "", "{", "no such thing", "/dev/null", "\xff\xfe", "{\"tissue\": 1}"};
  return rarely(h) ? odd[below(h, sizeof odd / sizeof *odd)] : right;
}
static void* place(Host* h, void* right) { return rarely(h) ? NULL : right; }

static void pose(Host* h, typodont_pose* X) {
  for (int i = 0; i < 3; ++i) X->p[i] = number(h, 3e-3);
  X->q[0] = rarely(h) ? number(h, 1) : 1;
  for (int i = 1; i < 4; ++i) X->q[i] = rarely(h) ? number(h, 1) : 0;
}
static typodont_sample sample(Host* h) {
  typodont_sample s = {.struct_size = size_of(h, sizeof s), .tool = rarely(h) ? below(h, 9) : 0};
  s.t_ns = (int64_t)below(h, 1u << 30) * 1000;
  pose(h, &s.X_WT);
  s.pedal = fabs(number(h, 1));
  return s;
}
/* The caller's memory for an array or a struct whose size is right, most of the time. */
static void* out(Host* h, size_t right) {
  const uint32_t size = size_of(h, right);
  memset(h->out, 0, sizeof h->out);
  memcpy(h->out, &size, sizeof size);
  return place(h, h->out);
}

static typodont_result call(Host* h) {
  void* made = NULL;
  const char* words;
  size_t count = 0;
  int32_t done;
  uint64_t hash;
  double numbers[3 * kCount];
  for (int i = 0; i < 3 * kCount; ++i) numbers[i] = number(h, 2e-3);
  const int32_t low[3] = {(int32_t)below(h, 40) - 20, -4, -4};
  const int32_t size[3] = {rarely(h) ? 1 << 21 : (int32_t)below(h, 9), 8, 8};
  const typodont_sample s = sample(h);
  typodont_cut cut = {.struct_size = size_of(h, sizeof cut)};
  switch (below(h, kFunctions)) {
    case 0: {
      const typodont_result r = typodont_scene_parse(text(h, kScene), text(h, NULL), text(h, NULL), place(h, &made));
      return keep(h, made), r;
    }
    case 1: return typodont_scene_text(handle(h), place(h, &words));
    case 2: return typodont_scene_tool(handle(h), below(h, 3), place(h, &words));
    case 3: return typodont_scene_model(handle(h), place(h, &words));
    case 4: return rarely(h) ? typodont_scene_free(handle(h)) : TYPODONT_OK;
    case 5: {
      typodont_hand_row rows[kCount];
      for (int i = 0; i < kCount; ++i) {
        rows[i] = (typodont_hand_row){.struct_size = sizeof rows[0], .t = i + (rarely(h) ? number(h, 9) : 0)};
        pose(h, &rows[i].X_WT);
      }
      rows[0].struct_size = rarely(h) ? 8 : sizeof rows[0];
      const typodont_result r = typodont_hand_path(place(h, rows), below(h, kCount + 1), fabs(number(h, 2000)), NULL, place(h, &made));
      return keep(h, made), r;
    }
    case 6: return typodont_hand_read(handle(h), out(h, sizeof(typodont_sample)));
    case 7: return typodont_hand_write(handle(h), place(h, numbers), place(h, numbers + 3));
    case 8: return typodont_hand_free(handle(h));
    case 9: case 10: {
      typodont_core_options o = {.struct_size = size_of(h, sizeof o), .rate = fabs(number(h, 4000)), .position_step = fabs(number(h, 1e-4))};
      const typodont_result r = typodont_core_new(handle(h), rarely(h) ? handle(h) : NULL, below(h, 2) ? &o : NULL, place(h, &made));
      return keep(h, made), r;
    }
    case 11: return rarely(h) ? typodont_core_free(handle(h)) : TYPODONT_OK;
    case 12: case 13: case 14: case 15: return typodont_core_tick(handle(h), place(h, (void*)&s), out(h, sizeof(typodont_tick)), place(h, &cut));
    case 16: return typodont_core_run(handle(h), handle(h), out(h, sizeof(typodont_tick)), below(h, kCount + 1), place(h, &count));
    case 17: {
      const typodont_result r = typodont_core_servo(handle(h), place(h, numbers), place(h, &made));
      return keep(h, made), r;
    }
    case 18: case 19: return typodont_servo_tick(handle(h), place(h, (void*)&s), out(h, sizeof(typodont_tick)), place(h, &cut));
    case 20: return typodont_core_carve(handle(h), place(h, &done));
    case 21: return typodont_servo_free(handle(h));
    case 22: return typodont_core_undo(handle(h), place(h, &done));
    case 23: return typodont_core_redo(handle(h), place(h, &done));
    case 24: {
      const typodont_mesh_part* parts;
      return typodont_core_mesh(handle(h), place(h, &parts), place(h, &count));
    }
    case 25: return typodont_core_field(handle(h), out(h, sizeof(typodont_field)));
    case 26: return typodont_core_query(handle(h), place(h, numbers), below(h, kCount + 1), place(h, h->out), place(h, h->out + kLargest));
    case 27: return typodont_core_copy(handle(h), place(h, (void*)low), place(h, (void*)size), place(h, h->out), place(h, h->out + kLargest));
    case 28: return typodont_core_volumes(handle(h), place(h, h->out));
    case 29: return typodont_core_hash(handle(h), place(h, &hash));
    case 30: return typodont_core_record(handle(h), text(h, h->file), text(h, "a person"));
    case 31: return typodont_core_finish(handle(h));
    case 32: {
      const typodont_result r = typodont_session_open(text(h, h->file), place(h, &made));
      return keep(h, made), r;
    }
    case 33: {
      switch (below(h, 6)) {
        case 0: return typodont_session_info_of(handle(h), out(h, sizeof(typodont_session_info)));
        case 1: return typodont_session_text(handle(h), text(h, "scene"), place(h, &words));
        case 2: return typodont_session_ticks(handle(h), below(h, 99), out(h, sizeof(typodont_tick)), below(h, kCount + 1), place(h, &count));
        case 3: return typodont_session_cuts(handle(h), below(h, 99), out(h, sizeof(typodont_cut)), below(h, kCount + 1), place(h, &count));
        case 4: return typodont_session_event(handle(h), below(h, 9), out(h, sizeof(typodont_event)));
        default: return typodont_session_free(handle(h));
      }
    }
    case 34: {
      const typodont_sound_state state = {.struct_size = size_of(h, sizeof state), .spindle = number(h, 3e4), .pedal = number(h, 1),
                                          .force = number(h, 5), .turns = below(h, 2), .tissue = below(h, 20)};
      switch (below(h, 4)) {
        case 0: {
          const typodont_result r = typodont_synth_new(text(h, "micromotor"), fabs(number(h, 96000)), 1, place(h, &made));
          return keep(h, made), r;
        }
        case 1: return typodont_synth_push(handle(h), place(h, (void*)&state));
        case 2: return typodont_synth_render(handle(h), place(h, h->out), below(h, 500));
        default: return typodont_synth_free(handle(h));
      }
    }
    default:
      if (below(h, 2)) return typodont_register(place(h, numbers), place(h, numbers + 3), below(h, kCount - 1), fabs(number(h, 1e-4)), out(h, sizeof(typodont_registration)), NULL);
      return typodont_estimate_delay(place(h, numbers), place(h, numbers), below(h, kCount), place(h, numbers), place(h, numbers), below(h, kCount), fabs(number(h, 1)), out(h, sizeof(typodont_delay)));
  }
}

static void* run(void* user) {
  Host* const h = user;
  snprintf(h->file, sizeof h->file, "random_%d.h5", h->number);
  for (long i = 0; i < calls; ++i) {
    const typodont_result r = call(h);
    const int known = r >= TYPODONT_OK && r <= TYPODONT_NO_MEMORY;
    if (known) ++results[r];
    if (!known || (r != TYPODONT_OK && r != TYPODONT_END && !*typodont_error())) {
      ++failures;
      printf("thread %d, call %ld: result %d, text \"%s\"\n", h->number, i, r, typodont_error());
    }
  }
  remove(h->file);
  return NULL;
}

int main(int count, char** words) {
  static Host hosts[kThreads];
  pthread_t threads[kThreads];
  if (count != 3) return 2;
  calls = atol(words[2]);
  for (int i = 0; i < kThreads; ++i) {
    hosts[i].state = 0x9E3779B97F4A7C15ull * (uint64_t)(atol(words[1]) * kThreads + i + 1);
    hosts[i].number = i;
    pthread_create(&threads[i], NULL, run, &hosts[i]);
  }
  for (int i = 0; i < kThreads; ++i) pthread_join(threads[i], NULL);
  printf("%ld failures; results:", (long)failures);
  for (int r = 0; r <= TYPODONT_NO_MEMORY; ++r) printf(" %ld", (long)results[r]);
  printf("\n");
  return failures != 0;
}
