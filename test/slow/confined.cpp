// SPDX-License-Identifier: MIT
#include "confined.hpp"

#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>

namespace confined {

namespace {

double resident_MB() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double largest_resident_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

struct Answer {
  double cpu_s = 0, growth_MB = 0;
};

[[noreturn]] void work(int to, double most_cpu_s, const std::function<double()>& f) {
  // Other threads of the parent are not in this process: nothing of it may be destroyed here, hence _exit.
  const rlimit limit{static_cast<rlim_t>(std::ceil(most_cpu_s)),
                     static_cast<rlim_t>(std::ceil(most_cpu_s)) + 1};
  setrlimit(RLIMIT_CPU, &limit);
  alarm(static_cast<unsigned>(std::ceil(10 * most_cpu_s)));  // for waits, which take no processor time
  malloc_trim(0);  // what the parent has freed would be used first, and not count
  const double before_MB = resident_MB();
  Answer answer;
  try {
    answer.cpu_s = f();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    _exit(3);
  }
  answer.growth_MB = largest_resident_MB() - before_MB;
  _exit(write(to, &answer, sizeof answer) == sizeof answer ? 0 : 4);
}

}  // namespace

Outcome run(double most_cpu_s, const std::function<double()>& f) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    work(ends[1], most_cpu_s, f);
  }
  close(ends[1]);
  Answer answer;
  const bool answered = child > 0 && read(ends[0], &answer, sizeof answer) == sizeof answer;
  close(ends[0]);
  int status = 0;
  if (child > 0) waitpid(child, &status, 0);
  Outcome outcome{Outcome::End::Died, answer.cpu_s, answer.growth_MB};
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL)
    outcome.end = Outcome::End::OutOfTime;
  else if (answered)
    outcome.end = Outcome::End::Done;
  return outcome;
}

std::string to_string(Outcome::End end) {
  switch (end) {
    case Outcome::End::Done:
      return "done";
    case Outcome::End::OutOfTime:
      return "out of time";
    default:
      return "died";
  }
}

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace confined
