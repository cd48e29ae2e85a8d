// Counters of a session's work, by kind. Only the thread that does the work increases its counter; the counter is read
// after this thread has ended.
#pragma once

#include <array>
#include <cstdint>

namespace typodont {

struct WorkCounts {
  // Counts of contact and cutting.
  std::uint64_t ticks = 0, queries = 0;  // number of servo ticks; number of distance field queries
  // Numbers of searches for tissue near the tool, made by contact models that represent tissue as spheres, triangles or
  // vertices (haptics/work.h).
  std::uint64_t sphere_looks = 0, triangle_looks = 0, vertex_looks = 0;
  /// Number of tissue patches that were made for the servo.
  std::uint64_t patches = 0;
  std::uint64_t voxels_cut = 0;  // number of voxels that cuts and fillings processed
  // Counts of the surface and of the pictures.
  std::uint64_t bricks_meshed = 0, triangles_made = 0;
  std::uint64_t frames = 0, passes = 0, triangles_drawn = 0;
  /// Number of mesh bricks that were not drawn: outside of the picture, facing away from the viewer, or hidden.
  std::uint64_t bricks_skipped = 0;
  std::uint64_t pipelines = 0;         // largest number of graphics pipelines that existed at the same time
  std::uint64_t turns = 0;             // passes of the drawing loop; most passes draw nothing
  std::uint64_t desktop_requests = 0;  // number of requests to the window system
  std::uint64_t samples = 0;           // number of sound samples that were computed
  std::uint64_t particles_stepped = 0;
  // Counts of the spray, and of the film of water and slurry on the tissue. film_texels: texels written for the film's
  // picture.
  std::uint64_t droplets_stepped = 0, film_cells_stepped = 0, film_texels = 0;
  // Counts of the whole process.
  std::uint64_t allocations = 0, threads = 0, libraries = 0, bytes_written = 0;
  double cpu_seconds = 0, servo_cpu_seconds = 0;  // s, CPU time: of all threads; of the servo thread
};

struct WorkCount {
  const char* name;  // name of the counter as a JSON key
  const char* words;
  std::uint64_t value;
};
/// All counters except times, in the order of WorkCounts.
std::array<WorkCount, 26> listed(const WorkCounts& counts);

/// Counts of this process so far: bytes written, allocations, CPU time, and current numbers of threads and libraries.
WorkCounts process_counts();

/// The time since the command was started, s. The system measures it with a resolution of 10 ms.
double seconds_since_command();

/// Counts an allocation, by one relaxed atomic addition. Called by operator new of the program typodont
/// (count_allocations.cpp); other programs count none. Real-time loops never allocate, so they never call it.
void count_allocation() noexcept;

}  // namespace typodont
