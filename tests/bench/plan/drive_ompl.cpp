// SPDX-License-Identifier: GPL-3.0-or-later
/* OMPL's planners on the bench's problems: bits looked up, segments walked exactly, in cells.
 *   drive_ompl PLANNER default|tuned PROBLEMS SEED BUDGET_MS
 * Only solve() is charged, not construction and setup(). A run ends within 1.02 of the optimum. */
#include <malloc.h>
#include <ompl/base/PlannerData.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/InformedRRTstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drive.h"

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;

/** What made them fastest to 1.05 x optimum in trials on such problems. */
const Settings TUNED_TREE = {
    {"use_k_nearest", "0"}, {"goal_bias", "0.15"}, {"delay_collision_checking", "0"}};
const Settings TUNED_BATCH = {{"use_k_nearest", "0"}, {"samples_per_batch", "50"}};
const Settings TUNED_CONNECT = {{"range", "18"}};

class Map {
public:
  explicit Map(const uint8_t *cells) : cells_(cells) {
  }

  bool blocked(int x, int y) const {
    return unsigned(x) >= unsigned(DRIVE_SIDE) || unsigned(y) >= unsigned(DRIVE_SIDE) ||
           cells_[y * DRIVE_SIDE + x] != 0;
  }

  /** Every cell whose inside the segment enters (Amanatides and Woo 1987). */
  bool segment_free(const double *a, const double *b) const {
    int cell[2], left = 0, step[2];
    double next[2], each[2];
    for (int axis = 0; axis < 2; axis++) {
      double delta = b[axis] - a[axis];
      cell[axis] = int(std::floor(a[axis]));
      left += std::abs(int(std::floor(b[axis])) - cell[axis]);
      step[axis] = delta > 0.0 ? 1 : -1;
      each[axis] = delta != 0.0 ? std::fabs(1.0 / delta) : INFINITY;
      double ahead = delta > 0.0 ? cell[axis] + 1 - a[axis] : a[axis] - cell[axis];
      next[axis] = delta != 0.0 ? ahead * each[axis] : INFINITY;
    }
    if (blocked(cell[0], cell[1])) {
      return false;
    }
    while (left-- > 0) {
      int axis = next[0] < next[1] ? 0 : 1;
      cell[axis] += step[axis];
      next[axis] += each[axis];
      if (blocked(cell[0], cell[1])) {
        return false;
      }
    }
    return true;
  }

private:
  const uint8_t *cells_;
};

const double *values(const ob::State *state) {
  return state->as<ob::RealVectorStateSpace::StateType>()->values;
}

class Validity : public ob::StateValidityChecker {
public:
  Validity(const ob::SpaceInformationPtr &si, const Map &map)
      : ob::StateValidityChecker(si), map_(map) {
  }
  bool isValid(const ob::State *state) const override {
    return !map_.blocked(int(std::floor(values(state)[0])), int(std::floor(values(state)[1])));
  }

private:
  Map map_;
};

class Motion : public ob::MotionValidator {
public:
  Motion(const ob::SpaceInformationPtr &si, const Map &map) : ob::MotionValidator(si), map_(map) {
  }
  bool checkMotion(const ob::State *a, const ob::State *b) const override {
    return map_.segment_free(values(a), values(b));
  }
  bool checkMotion(const ob::State *a, const ob::State *b,
                   std::pair<ob::State *, double> &last) const override {
    if (checkMotion(a, b)) {
      return true;
    }
    last.second = 0.0;
    if (last.first != nullptr) {
      si_->copyState(last.first, a);
    }
    return false;
  }

private:
  Map map_;
};

long heap_bytes() {
  struct mallinfo2 info = mallinfo2();
  return long(info.uordblks + info.hblkhd);
}

/** A planner whose best cost can be asked for while it runs. */
struct Candidate {
  ob::PlannerPtr planner;
  std::function<double()> cost; ///< none: of one way only, to be restarted
};

template <class Planner> Candidate anytime(const ob::SpaceInformationPtr &si) {
  auto planner = std::make_shared<Planner>(si);
  return {planner, [raw = planner.get()] { return raw->bestCost().value(); }};
}

Candidate make(const std::string &name, bool tuned, const ob::SpaceInformationPtr &si) {
  Candidate made;
  Settings settings = TUNED_TREE;
  if (name == "RRT*") {
    made = anytime<og::RRTstar>(si);
  } else if (name == "Informed RRT*") {
    made = anytime<og::InformedRRTstar>(si);
  } else if (name == "BIT*") {
    made = anytime<og::BITstar>(si);
    settings = TUNED_BATCH;
  } else if (name == "RRT-Connect") {
    made = {std::make_shared<og::RRTConnect>(si), nullptr};
    settings = TUNED_CONNECT;
  } else {
    std::fprintf(stderr, "no planner %s\n", name.c_str());
    std::exit(2);
  }
  for (const auto &[key, value] : tuned ? settings : Settings()) {
    if (!made.planner->params().setParam(key, value)) {
      std::fprintf(stderr, "%s has no parameter %s\n", name.c_str(), key.c_str());
      std::exit(2);
    }
  }
  return made;
}

/** Looks at the clock only about every 50 us, and at the cost whenever it is asked. */
class Watch {
public:
  Watch(drive_run_t &run, double budget_s) : run_(run), budget_s_(budget_s), base_(heap_bytes()) {
  }

  void note(double cost) {
    if (cost < run_.cost) {
      double now_s = drive_pause(&run_);
      if (drive_note(&run_, now_s, cost)) {
        run_.bytes_105 = heap_bytes() - base_;
      }
      drive_resume(&run_, now_s);
    }
  }

  bool done() {
    if (run_.cost <= 1.02 * run_.problem->optimum) {
      return true;
    }
    if (++asked_ >= look_at_) {
      double now_s = drive_time_s(&run_);
      every_ = now_s - looked_s_ < 50.0e-6 ? every_ * 2 : every_ > 1 ? every_ / 2 : 1;
      every_ = every_ < 1024 ? every_ : 1024;
      looked_s_ = now_s;
      look_at_ = asked_ + every_;
    }
    return looked_s_ >= budget_s_;
  }

  void finish() {
    run_.end_s = drive_time_s(&run_);
    run_.bytes_end = heap_bytes() - base_;
  }

private:
  drive_run_t &run_;
  double budget_s_;
  long base_;
  double looked_s_ = 0.0;
  unsigned asked_ = 0, look_at_ = 16, every_ = 16;
};

/** Solve, simplify, keep the best, start again. */
og::PathGeometric restart(const Candidate &candidate, const ob::ProblemDefinitionPtr &goal,
                          Watch &watch, const ob::SpaceInformationPtr &si) {
  og::PathGeometric best(si);
  og::PathSimplifier simplifier(si);
  ob::PlannerTerminationCondition enough([&] { return watch.done(); });
  double best_length = INFINITY;
  auto take = [&](const og::PathGeometric &path) {
    watch.note(path.length());
    if (path.length() < best_length) {
      best_length = path.length();
      best = path;
    }
  };
  while (!watch.done() && candidate.planner->solve(enough) == ob::PlannerStatus::EXACT_SOLUTION) {
    og::PathGeometric path(*goal->getSolutionPath()->as<og::PathGeometric>());
    if (std::isinf(best_length)) {
      take(path);
    }
    simplifier.simplifyMax(path);
    take(path);
    candidate.planner->clear();
    goal->clearSolutionPaths();
  }
  return best;
}

og::PathGeometric improve(const Candidate &candidate, const ob::ProblemDefinitionPtr &goal,
                          Watch &watch, const ob::SpaceInformationPtr &si) {
  candidate.planner->solve(ob::PlannerTerminationCondition([&] {
    watch.note(candidate.cost());
    return watch.done();
  }));
  if (goal->hasExactSolution()) {
    return *goal->getSolutionPath()->as<og::PathGeometric>();
  }
  return og::PathGeometric(si);
}

/** What OMPL returns must be a way, too. Its own walk is in double: 1/1000 cell is forgiven. */
void verify(drive_run_t &run, og::PathGeometric &path) {
  std::vector<double> way;
  for (const ob::State *state : path.getStates()) {
    way.insert(way.end(), values(state), values(state) + 2);
  }
  if (!way.empty() && drive_verify(&run, way.data(), int(way.size() / 2), 4194) >= 0.0) {
    drive_finish(&run, way.data(), int(way.size() / 2));
  }
}

void plan(drive_run_t &run, const drive_problem_t &problem, const std::string &name, bool tuned,
          double budget_s) {
  auto space = std::make_shared<ob::RealVectorStateSpace>(2);
  space->setBounds(0.0, DRIVE_SIDE);
  auto si = std::make_shared<ob::SpaceInformation>(space);
  Map map(problem.blocked);
  si->setStateValidityChecker(std::make_shared<Validity>(si, map));
  si->setMotionValidator(std::make_shared<Motion>(si, map));
  si->setup();
  auto goal = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<ob::RealVectorStateSpace> from(space), to(space);
  for (unsigned axis = 0; axis < 2; axis++) {
    from[axis] = problem.start[axis];
    to[axis] = problem.goal[axis];
  }
  goal->setStartAndGoalStates(from, to, 1.0e-9);
  goal->setOptimizationObjective(std::make_shared<ob::PathLengthOptimizationObjective>(si));
  Candidate candidate = make(name, tuned, si);
  candidate.planner->setProblemDefinition(goal);
  candidate.planner->setup();
  drive_begin(&run, &problem);
  Watch watch(run, budget_s);
  og::PathGeometric path = (candidate.cost ? improve : restart)(candidate, goal, watch, si);
  watch.finish();
  ob::PlannerData data(si);
  candidate.planner->getPlannerData(data);
  run.nodes_end = long(data.numVertices());
  verify(run, path);
}

} // namespace

int main(int argc, char **argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: drive_ompl PLANNER default|tuned PROBLEMS SEED BUDGET_MS\n");
    return 2;
  }
  mallopt(M_TRIM_THRESHOLD, 1 << 30); // keep freed pages: no page faults in later runs
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  ompl::RNG::setSeed(std::strtoul(argv[4], nullptr, 10));
  int count = 0;
  drive_problem_t *problems = drive_read(argv[3], &count);
  bool tuned = std::string(argv[2]) == "tuned";
  double budget_s = 1.0e-3 * std::strtod(argv[5], nullptr);
  drive_run_t run;
  plan(run, problems[0], argv[1], tuned, 0.02); // to warm up
  drive_print_header();
  for (int i = 0; i < count; i++) {
    plan(run, problems[i], argv[1], tuned, budget_s);
    drive_print(i, &run);
  }
  std::free(problems);
  return 0;
}
