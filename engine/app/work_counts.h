// Counters for the work of a session, by kind. Each counter is increased only by the thread that does the work, and is
// read after this thread has ended.
#pragma once

#include <array>
#include <cstdint>

namespace typodont {

struct WorkCounts {
  // Counts of contact and cutting.
  std::uint64_t ticks = 0, queries = 0;  // number of ticks of the servo; number of queries of the distance field
  // Contact models that represent tissue as spheres, triangles or vertices search for the tissue near the tool. These
  // are the numbers of their searches (haptics/work.h).
  std::uint64_t sphere_looks = 0, triangle_looks = 0, vertex_looks = 0;
  /// number of patches (copies of the tissue around the tool) that were created for the servo
  std::uint64_t patches = 0;
  std::uint64_t voxels_cut = 0;  // number of voxels that cuts and fillings processed
  // Counts of the surface and of the pictures.
  std::uint64_t bricks_meshed = 0, triangles_made = 0;
  std::uint64_t frames = 0, passes = 0, triangles_drawn = 0;
  /// number of bricks (mesh blocks) that were not drawn, because they are outside the picture, face away from the
  /// viewer or are hidden by others
  std::uint64_t bricks_skipped = 0;
  std::uint64_t pipelines = 0;         // largest number of graphics pipelines that existed at the same time
  std::uint64_t turns = 0;             // number of passes of the drawing loop; most passes draw nothing
  std::uint64_t desktop_requests = 0;  // number of requests to the window system
  std::uint64_t samples = 0;           // number of sound samples that were computed
  std::uint64_t particles_stepped = 0;
  // Counts of the spray, and of the film of water and slurry on the tissue. film_texels: number of texels that were
  // written for the film's picture.
  std::uint64_t droplets_stepped = 0, film_cells_stepped = 0, film_texels = 0;
  // Counts of the whole process.
  std::uint64_t allocations = 0, threads = 0, libraries = 0, bytes_written = 0;
  double cpu_seconds = 0, servo_cpu_seconds = 0;  // s, CPU time of all threads together, and of the servo thread
};

struct WorkCount {
  const char* name;  // name of the counter as a JSON key
  const char* words;
  std::uint64_t value;
};
/// Lists all counters except the times, in the order of WorkCounts.
std::array<WorkCount, 26> listed(const WorkCounts& counts);

/// Counts of this process so far: bytes written, allocations, CPU time, and its present numbers of threads and
/// libraries.
WorkCounts process_counts();

/// Returns the time since the command was started, s. The system measures it with a resolution of 10 ms.
double seconds_since_command();

/// Counts an allocation. Called by operator new of the program typodont (count_allocations.cpp); other programs count
/// no allocations. A call costs one relaxed atomic addition. Real-time loops never allocate, so they never call this
/// function.
void count_allocation() noexcept;

}  // namespace typodont
