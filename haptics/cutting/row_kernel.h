// After cut_kernel.h, with eight lanes. Rows that may lie partly outside.

/// One per lane; only `from` to `to` - 1.
struct Row {
  float* distance;
  int from, to;
  bool whole;  // true if all samples are processed

  /// Others get a value that no cut raises.
  TYPODONT_INLINE Floats read() const {
    if (whole) return load(distance);
    Floats old = all(1e9f);
    for (int i = from; i < to; ++i) old[i] = distance[i];
    return old;
  }
  /// `labels`: only if volume is counted.
  TYPODONT_INLINE void write(Floats old, Floats now, const Tissue* labels, Taken& taken) const {
    if (whole) {
      store(distance, now);
    } else {
      for (int i = from; i < to; ++i) distance[i] = now[i];
    }
    const Ints lost = share_taken(old, now);
    if (!taken.removed || !any_of(lost > 0)) return;
    taken.add(lost, labels, distance, from, to);
  }
};
