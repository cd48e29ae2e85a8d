// A core of the C interface with two threads: one for its servo and one for its tissue.
#pragma once

#include <typodont.h>

#include <atomic>

#include "Containers/TripleBuffer.h"
#include "CoreMinimal.h"
#include "HAL/Runnable.h"
#include "HAL/RunnableThread.h"
#include "Templates/Function.h"
#include "Templates/UniquePtr.h"

/** Calls `Step` on its own thread until it is destroyed. */
class FTypodontLoop : public FRunnable {
 public:
  FTypodontLoop(const TCHAR* Name, EThreadPriority Priority, TFunction<void()> Step);
  virtual ~FTypodontLoop() override;

  virtual uint32 Run() override;
  virtual void Stop() override { bStop = true; }

 private:
  TFunction<void()> Step;
  std::atomic<bool> bStop{false};
  FRunnableThread* Thread;
};

/** Owned by the game thread, which calls all functions. */
class FTypodontBench {
 public:
  ~FTypodontBench();

  /** Loads the scene and starts both threads. Returns the reason of a failure; empty: none. */
  FString Open(const FString& Scene, const typodont_pose& Hand);
  /** The newest pose of the hand, and the newest tick. Neither waits. */
  void Send(const typodont_sample& Sample) { Samples.WriteAndSwap(Sample); }
  const typodont_tick& Newest() { return Ticks.SwapAndRead(); }
  bool Undo();
  /** Calls `Show` for each brick whose surface changed; `Show` must copy the brick. */
  void ChangedBricks(TFunction<void(const typodont_mesh_part&)> Show);

 private:
  void ServoStep();
  void TissueStep();

  typodont_core* Core = nullptr;
  typodont_servo* Servo = nullptr;
  // Protects the core, which the game thread and the tissue's thread use. The servo thread does not lock this mutex.
  FCriticalSection CoreLock;
  TTripleBuffer<typodont_sample> Samples;
  TTripleBuffer<typodont_tick> Ticks;
  double Start = 0;    // s, time of the servo's first tick
  int64 Ticked = 0;    // number of ticks so far; only the servo thread uses it
  typodont_pose Felt;  // the hand's pose in the newest tick; only the servo thread uses it
  TUniquePtr<FTypodontLoop> ServoLoop, TissueLoop;
};
