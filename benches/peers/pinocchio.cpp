// Pinocchio's inverse dynamics of the seven-joint arm of crates/sinew/tests/sinew/description/pinocchio.json, called from
// C++: least and median of the rounds, ns per pose.
//
//   pinocchio ARM.txt         (a model that Python saved; benches/peers/body.sh compiles and runs this)
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/serialization.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

int main(int count, char** words) {
    if (count != 2) return 2;
    pinocchio::Model model;
    model.loadFromText(words[1]);
    pinocchio::Data data(model);
    const int rounds = 301, calls = 2000, poses = 64;
    std::vector<Eigen::VectorXd> q, v, a;
    for (int k = 0; k < poses; ++k) {
        q.push_back(Eigen::VectorXd::Random(model.nq));
        v.push_back(Eigen::VectorXd::Random(model.nv));
        a.push_back(Eigen::VectorXd::Random(model.nv));
    }
    std::vector<double> times;
    double sum = 0;
    for (int round = 0; round < rounds; ++round) {
        const auto start = std::chrono::steady_clock::now();
        for (int k = 0; k < calls; ++k) sum += pinocchio::rnea(model, data, q[k % poses], v[k % poses], a[k % poses])[0];
        const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
        times.push_back(took.count() / calls);
    }
    std::sort(times.begin(), times.end());
    std::printf("pinocchio from C++ inverse dynamics, %d joints: least %.0f ns, median %.0f ns (sum %g)\n", int(model.nv),
                times[0], times[rounds / 2], sum);
}
