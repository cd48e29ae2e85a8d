/* two_threads SCENE RECORDED: a servo thread of 1 kHz without a clock and the tissue on the main thread. Strokes are taken back and
 * brought again; everything is recorded. Prints what the tissue lost by the ticks and by its own volumes. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <typodont.h>

static typodont_servo* servo;
static atomic_int over, ticks;
static atomic_long paced = 0; /* ticks that the main thread has allowed */
static typodont_tick last = {.struct_size = sizeof last};

static void* feel(void* unused) {
  typodont_sample sample = {.struct_size = sizeof sample, .X_WT = {{0, 0, 3.8e-3}, {1, 0, 0, 0}}, .pedal = 1};
  for (long i = 0; i < 4000; ++i) {
    while (i >= paced) sched_yield();
    sample.t_ns = i * 1000000;
    const long phase = i % 2000; /* down for half a second, along for one, up and away */
    sample.X_WT.p[2] = phase < 500 ? 3.8e-3 - phase * 1.4e-6 : phase < 1500 ? 3.1e-3 : 3.1e-3 + (phase - 1500) * 1.4e-6;
    sample.X_WT.p[0] = phase > 500 && phase < 1500 ? (phase - 500) * 4e-7 : phase < 1500 ? 0 : 4e-4;
    if (typodont_servo_tick(servo, &sample, &last, NULL) != TYPODONT_OK) {
      fprintf(stderr, "%s\n", typodont_error());
      exit(1);
    }
    ++ticks;
  }
  over = 1;
  return unused;
}

int main(int count, char** words) {
  typodont_scene* scene;
  typodont_core* core;
  const double start[3] = {0, 0, 3.8e-3};
  double before[TYPODONT_TISSUES], after[TYPODONT_TISSUES];
  if (count != 3 || typodont_scene_open(words[1], NULL, &scene) || typodont_core_new(scene, NULL, NULL, &core) ||
      typodont_core_volumes(core, before) || typodont_core_record(core, words[2], "two threads") ||
      typodont_core_servo(core, start, &servo)) {
    fprintf(stderr, "%s\n", typodont_error());
    return 1;
  }
  pthread_t thread;
  pthread_create(&thread, NULL, feel, NULL);
  int undone = 0;
  size_t parts = 0, changed = 0;
  const typodont_mesh_part* part;
  while (!over) {
    if (typodont_core_carve(core, NULL)) return fprintf(stderr, "%s\n", typodont_error()), 1;
    paced = ticks + 4; /* the servo never runs ahead by more: the carver is in time however busy the machine is */
    if (ticks % 200 == 0) {
      if (typodont_core_mesh(core, &part, &parts)) return 1;
      changed += parts;
    }
    int32_t did = 0;
    if (!undone && ticks > 1990 && typodont_core_undo(core, &did) == TYPODONT_OK && did) undone = 1;
    if (undone == 1 && ticks > 2010 && typodont_core_redo(core, &did) == TYPODONT_OK && did) undone = 2;
  }
  pthread_join(thread, NULL);
  if (typodont_core_finish(core) || typodont_core_volumes(core, after)) return fprintf(stderr, "%s\n", typodont_error()), 1;
  printf("%d ticks, %d edits, %zu parts, removed %.9f mm3 by ticks, %.9f mm3 by volumes\n", (int)ticks, undone, changed,
         1e9 * last.removed[1], 1e9 * (before[1] - after[1]));
  return typodont_servo_free(servo) || typodont_core_free(core) || typodont_scene_free(scene);
}
