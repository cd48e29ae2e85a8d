/* Whatever a host does wrong is an error with a text, and never a crash of the host. */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <typodont.h>
#include <typodont_calibration.h>
#include <typodont_sound.h>

static atomic_int failures;
#define EXPECT(result, call)                                                              \
  do {                                                                                    \
    const typodont_result found = (call);                                                 \
    if (found != (result) || (found && !*typodont_error())) {                             \
      printf("line %d: found %d (%s), expected " #result "\n", __LINE__, found, typodont_error()); \
      ++failures;                                                                         \
    }                                                                                     \
  } while (0)

static const char* const kScene =
    "{\"tissue\": {\"voxel_mm\": 0.1, \"solids\": [{\"tissue\": \"enamel\", \"solid\": {\"sphere\": {\"radius_mm\": 2}}}]},"
    " \"tool\": \"round_012\", \"spindle_krpm\": 300}";

static typodont_core* shared;
static atomic_int refused, done, going = 1;

static void* use_at_once(void* unused) {
  typodont_sample sample = {.struct_size = sizeof sample, .t_ns = 20000000, .X_WT = {{0, 0, 3e-3}, {1, 0, 0, 0}}};
  typodont_tick tick = {.struct_size = sizeof tick};
  while (going) {
    const typodont_result result = typodont_core_tick(shared, &sample, &tick, NULL);
    if (result == TYPODONT_BUSY) ++refused;
    if (result == TYPODONT_OK) ++done;
    if (refused >= 100 && done >= 100) going = 0;
  }
  return unused;
}

/* A core of its own, recorded, and its session read again. */
static void* record(void* file) {
  typodont_scene* scene = NULL;
  typodont_core* core = NULL;
  typodont_session* session = NULL;
  typodont_sample sample = {.struct_size = sizeof sample, .X_WT = {{0, 0, 2.7e-3}, {1, 0, 0, 0}}, .pedal = 1};
  typodont_tick tick = {.struct_size = sizeof tick};
  typodont_session_info info = {.struct_size = sizeof info};
  EXPECT(TYPODONT_OK, typodont_scene_parse(kScene, NULL, NULL, &scene));
  EXPECT(TYPODONT_OK, typodont_core_new(scene, NULL, NULL, &core));
  EXPECT(TYPODONT_OK, typodont_core_record(core, file, NULL));
  for (int i = 0; i < 3000; ++i) {
    sample.t_ns = i * 1000000LL;
    if (i < 500) sample.X_WT.p[2] -= 1e-6;
    EXPECT(TYPODONT_OK, typodont_core_tick(core, &sample, &tick, NULL));
  }
  EXPECT(TYPODONT_OK, typodont_core_finish(core));
  EXPECT(TYPODONT_OK, typodont_session_open(file, &session));
  EXPECT(TYPODONT_OK, typodont_session_info_of(session, &info));
  if (info.ticks != 3000 || info.cuts == 0) ++failures;
  EXPECT(TYPODONT_OK, typodont_session_free(session));
  EXPECT(TYPODONT_OK, typodont_core_free(core));
  EXPECT(TYPODONT_OK, typodont_scene_free(scene));
  return NULL;
}

int main(void) {
  typodont_scene* scene = NULL;
  typodont_core* core = NULL;
  typodont_hand* hand = NULL;
  typodont_servo* servo = NULL;
  typodont_synth* synth = NULL;
  typodont_session* session = NULL;
  typodont_sample sample = {.struct_size = sizeof sample, .X_WT = {{0, 0, 2.5e-3}, {1, 0, 0, 0}}};
  typodont_tick tick = {.struct_size = sizeof tick};
  typodont_cut cut = {.struct_size = sizeof cut};
  double numbers[3] = {0, 0, 3e-3};

  /* Names and texts that are none. */
  EXPECT(TYPODONT_BAD_INPUT, typodont_scene_open(NULL, NULL, &scene));
  EXPECT(TYPODONT_BAD_INPUT, typodont_scene_open("no such scene", NULL, &scene));
  EXPECT(TYPODONT_BAD_INPUT, typodont_scene_open("tutorial", NULL, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_scene_open("tutorial", "no such model", &scene));
  EXPECT(TYPODONT_BAD_INPUT, typodont_scene_parse("{", NULL, NULL, &scene));
  EXPECT(TYPODONT_BAD_INPUT, typodont_session_open("/dev/zero", &session));
  EXPECT(TYPODONT_BAD_INPUT, typodont_synth_new("no such voice", 48000, 1, &synth));
  EXPECT(TYPODONT_BAD_INPUT, typodont_synth_new("micromotor", NAN, 1, &synth));
  EXPECT(TYPODONT_BAD_INPUT, typodont_sound_fit("no such file", NULL, "model.json", NULL));
  EXPECT(TYPODONT_OK, typodont_scene_parse(kScene, NULL, NULL, &scene));

  /* NULL as a handle, a handle of another kind, a forged one. */
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_new(NULL, NULL, NULL, &core));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_tick(NULL, &sample, &tick, NULL));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_tick((typodont_core*)scene, &sample, &tick, NULL));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_tick((typodont_core*)(void*)&tick, &sample, &tick, NULL));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_free((typodont_core*)(~(uintptr_t)0)));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_servo_tick(NULL, &sample, &tick, NULL));
  EXPECT(TYPODONT_OK, typodont_core_free(NULL));

  /* Structs of wrong sizes, options out of range. */
  typodont_core_options options = {0};
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_new(scene, NULL, &options, &core));
  options.struct_size = sizeof options;
  options.rate = NAN;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_new(scene, NULL, &options, &core));
  options.rate = 2000;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_new(scene, NULL, &options, NULL));
  EXPECT(TYPODONT_OK, typodont_core_new(scene, NULL, &options, &core));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, NULL, &tick, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, NULL, NULL));
  tick.struct_size = sizeof tick - 8;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, &tick, NULL));
  tick.struct_size = sizeof tick;
  sample.struct_size = 1u << 31;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, &tick, NULL));
  sample.struct_size = sizeof sample;
  cut.struct_size = 4;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, &tick, &cut));
  cut.struct_size = sizeof cut;
  sample.tool = 7;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, &tick, &cut));
  sample.tool = 0;

  /* Poses that are none: no force, and the hand goes on afterwards. */
  EXPECT(TYPODONT_OK, typodont_core_tick(core, &sample, &tick, &cut));
  const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
  for (int i = 0; i < 4; ++i) {
    typodont_sample wrong = sample;
    wrong.t_ns = 1000000 * (i + 1);
    wrong.X_WT.p[i % 3] = bad[i];
    EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &wrong, &tick, &cut));
    if (tick.force[0] != 0 || tick.force[1] != 0 || tick.force[2] != 0 || !(tick.faults & TYPODONT_FAULT_BAD_INPUT)) ++failures;
    wrong = sample;
    wrong.X_WT.q[i] = i == 0 ? 2 : bad[i - 1];
    EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &wrong, &tick, &cut));
    wrong = sample;
    wrong.pedal = i < 3 ? bad[i] : NAN;
    EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &wrong, &tick, &cut));
  }
  sample.t_ns = 20000000;
  EXPECT(TYPODONT_OK, typodont_core_tick(core, &sample, &tick, &cut));

  /* Places, boxes, files. */
  double distance;
  const double nowhere[3] = {NAN, 0, 0};
  const int32_t low[3] = {0, 0, 0}, size[3] = {1 << 20, 1 << 20, 1 << 20}, none[3] = {0, 1, 1};
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_query(core, nowhere, 1, &distance, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_query(core, NULL, 1, &distance, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_copy(core, low, size, NULL, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_copy(core, low, none, NULL, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_save(core, "/no/such/folder/t.vdb"));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_record(core, "late.h5", NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_finish(core));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_carve(core, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_servo(core, numbers, &servo));
  EXPECT(TYPODONT_BAD_INPUT, typodont_hand_open(scene, "no such hand.csv", 1000, &hand));
  typodont_hand_row rows[2] = {{.struct_size = sizeof rows[0], .t = 1, .X_WT = sample.X_WT},
                               {.struct_size = sizeof rows[0], .t = 0, .X_WT = sample.X_WT}};
  EXPECT(TYPODONT_BAD_INPUT, typodont_hand_path(rows, 2, 1000, NULL, &hand));
  EXPECT(TYPODONT_BAD_INPUT, typodont_hand_path(rows, 0, 1000, NULL, &hand));
  rows[1].t = NAN;
  EXPECT(TYPODONT_BAD_INPUT, typodont_hand_path(rows, 2, 1000, NULL, &hand));
  rows[1].t = 2;
  rows[1].tool = 9;
  EXPECT(TYPODONT_OK, typodont_hand_path(rows, 2, 1000, NULL, &hand));
  size_t count = 0;
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_run(core, hand, NULL, 4000, &count));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_run(core, NULL, NULL, 1, &count));
  typodont_registration registration = {.struct_size = sizeof registration};
  EXPECT(TYPODONT_BAD_INPUT, typodont_register(nowhere, nowhere, 1, 0, &registration, NULL));
  EXPECT(TYPODONT_BAD_INPUT, typodont_register(NULL, NULL, 3, 0, &registration, NULL));

  /* Use after free. */
  EXPECT(TYPODONT_OK, typodont_hand_free(hand));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_hand_free(hand));
  EXPECT(TYPODONT_OK, typodont_core_free(core));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_free(core));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_tick(core, &sample, &tick, NULL));
  typodont_core* const freed = core;
  EXPECT(TYPODONT_OK, typodont_core_new(scene, NULL, NULL, &core));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_core_tick(freed, &sample, &tick, NULL));
  EXPECT(TYPODONT_OK, typodont_core_tick(core, &sample, &tick, NULL));

  /* Two threads at once: one is served, the other is told. */
  shared = core;
  pthread_t other;
  pthread_create(&other, NULL, use_at_once, NULL);
  use_at_once(NULL);
  pthread_join(other, NULL);
  EXPECT(TYPODONT_OK, typodont_core_free(core));

  /* The servo outlives its core. */
  EXPECT(TYPODONT_OK, typodont_core_new(scene, NULL, NULL, &core));
  EXPECT(TYPODONT_OK, typodont_core_servo(core, numbers, &servo));
  EXPECT(TYPODONT_BAD_INPUT, typodont_core_tick(core, &sample, &tick, NULL));
  EXPECT(TYPODONT_OK, typodont_servo_tick(servo, &sample, &tick, NULL));
  EXPECT(TYPODONT_OK, typodont_core_free(core));
  EXPECT(TYPODONT_OK, typodont_servo_tick(servo, &sample, &tick, NULL));
  EXPECT(TYPODONT_OK, typodont_servo_free(servo));
  EXPECT(TYPODONT_BAD_HANDLE, typodont_servo_tick(servo, &sample, &tick, NULL));

  /* A recording whose carver never came. */
  EXPECT(TYPODONT_OK, typodont_core_new(scene, NULL, NULL, &core));
  EXPECT(TYPODONT_OK, typodont_core_record(core, "lost.h5", NULL));
  EXPECT(TYPODONT_OK, typodont_core_servo(core, numbers, &servo));
  for (int i = 0; i < 80000; ++i) {
    sample.t_ns = i * 1000000LL;
    EXPECT(TYPODONT_OK, typodont_servo_tick(servo, &sample, &tick, NULL));
  }
  EXPECT(TYPODONT_FAILED, typodont_core_carve(core, NULL));
  EXPECT(TYPODONT_FAILED, typodont_core_finish(core));
  EXPECT(TYPODONT_OK, typodont_servo_free(servo));
  EXPECT(TYPODONT_OK, typodont_core_free(core));
  FILE* const lost = fopen("lost.h5", "rb");
  if (lost) ++failures;
  EXPECT(TYPODONT_OK, typodont_scene_free(scene));

  /* Cores on several threads, each recorded. */
  char files[4][32];
  pthread_t threads[4];
  for (int i = 0; i < 4; ++i) {
    snprintf(files[i], sizeof files[i], "hostile_%d.h5", i);
    pthread_create(&threads[i], NULL, record, files[i]);
  }
  for (int i = 0; i < 4; ++i) pthread_join(threads[i], NULL), remove(files[i]);
  printf("%d failures, %d ticks beside %d refusals\n", (int)failures, (int)done, (int)refused);
  return failures != 0;
}
