// Counts the work of a session by kind. Each number is incremented only by the thread that does the work, and is read
// after that thread has ended.
#pragma once

#include <array>
#include <cstdint>

namespace typodont {

struct WorkCounts {
  // Counts of contact and cutting.
  std::uint64_t ticks = 0, queries = 0;  // ticks of the servo; queries of the distance field
  // Numbers of searches for tissue by the contact models that represent tissue as spheres, triangles or vertices
  // (haptics/work.h).
  std::uint64_t sphere_looks = 0, triangle_looks = 0, vertex_looks = 0;
  std::uint64_t patches = 0;     // surface patches created for the servo
  std::uint64_t voxels_cut = 0;  // voxels processed by cuts and fillings
  // Counts of surface and picture.
  std::uint64_t bricks_meshed = 0, triangles_made = 0;
  std::uint64_t frames = 0, passes = 0, triangles_drawn = 0;
  std::uint64_t bricks_skipped = 0;    // bricks that were culled, face away or are covered
  std::uint64_t pipelines = 0;         // largest number of pipelines at one time
  std::uint64_t turns = 0;             // turns of the drawing thread; most of them draw nothing
  std::uint64_t desktop_requests = 0;  // requests to the desktop
  std::uint64_t samples = 0;           // samples of sound
  std::uint64_t particles_stepped = 0;
  // Work for the spray and for the film of water and slurry on the tissue. film_texels: number of texels written for
  // the picture.
  std::uint64_t droplets_stepped = 0, film_cells_stepped = 0, film_texels = 0;
  // Counts of the process.
  std::uint64_t allocations = 0, threads = 0, libraries = 0, bytes_written = 0;
  double cpu_seconds = 0, servo_cpu_seconds = 0;  // s, CPU time of all threads, and of the servo thread
};

struct WorkCount {
  const char* name;  // name as a JSON key
  const char* words;
  std::uint64_t value;
};
/// All counts except the times, in order.
std::array<WorkCount, 26> listed(const WorkCounts& counts);

/// Counts of the process so far: bytes written, allocations, CPU time; also its present threads and libraries.
WorkCounts process_counts();

/// Time since the command was started, s, with the system's resolution of 10 ms.
double seconds_since_command();

/// Called by this program's operator new; other programs count no allocations. One relaxed addition per allocation;
/// real-time loops never allocate.
void count_allocation() noexcept;

}  // namespace typodont
