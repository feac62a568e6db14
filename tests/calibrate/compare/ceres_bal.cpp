// A problem of Bundle Adjustment in the Large by Ceres, to stand beside `plumbline adjust` on the same machine.
//
//     g++ -O3 -I/usr/include/eigen3 ceres_bal.cpp -lceres -lglog -o ceres_bal && ./ceres_bal PROBLEM
//
// The model is the format's; the solver is what Ceres' documents use for such problems: dense Schur complement.

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <cstdio>
#include <thread>
#include <vector>

struct Snavely {
    double x, y;
    template <typename T>
    bool operator()(const T* camera, const T* point, T* residual) const {
        T p[3];
        ceres::AngleAxisRotatePoint(camera, point, p);
        for (int k = 0; k < 3; ++k) p[k] += camera[3 + k];
        const T u = -p[0] / p[2], v = -p[1] / p[2];
        const T r2 = u * u + v * v;
        const T factor = camera[6] * (1.0 + r2 * (camera[7] + r2 * camera[8]));
        residual[0] = factor * u - x;
        residual[1] = factor * v - y;
        return true;
    }
};

int main(int count, char** names) {
    FILE* file = count == 2 ? std::fopen(names[1], "r") : nullptr;
    int cameras, points, observations;
    if (!file || std::fscanf(file, "%d %d %d", &cameras, &points, &observations) != 3) return 2;
    std::vector<int> camera(observations), point(observations);
    std::vector<double> image(2 * observations), x(9 * cameras + 3 * points);
    for (int k = 0; k < observations; ++k)
        if (std::fscanf(file, "%d %d %lf %lf", &camera[k], &point[k], &image[2 * k], &image[2 * k + 1]) != 4) return 2;
    for (double& value : x)
        if (std::fscanf(file, "%lf", &value) != 1) return 2;
    ceres::Problem problem;
    for (int k = 0; k < observations; ++k)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Snavely, 2, 9, 3>(new Snavely{image[2 * k], image[2 * k + 1]}), nullptr,
            &x[9 * camera[k]], &x[9 * cameras + 3 * point[k]]);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.num_threads = static_cast<int>(std::thread::hardware_concurrency());
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    std::printf("ceres cost %.6e in %.2f s, %d iterations\n", summary.final_cost, summary.total_time_in_seconds,
                summary.num_successful_steps + summary.num_unsuccessful_steps);
}
