// SPDX-License-Identifier: GPL-3.0-or-later
// Threads meet, compute what one does, and where the system gives no more of them (a container's limit, no
// memory for a stack), those that run do the work of all.
#include <gtest/gtest.h>

#ifdef __GLIBC__
#include <pthread.h>
#endif

#include <atomic>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "base/errors.h"
#include "base/solve_team.h"

namespace rumple {
namespace {

// Sums of neighbours, in rounds with a barrier between them: as relaxation does it.
std::vector<float> relaxed(int threads) {
    std::vector<float> values[2];
    for (int i = 0; i < 100; ++i) values[0].push_back(float(i * i % 17));
    values[1] = values[0];
    Team team(threads);
    team.run([&](int thread) {
        for (int round = 0; round < 6; ++round) {
            const Team::Range part = team.partition(1, 99, thread);
            const std::vector<float>& from = values[round % 2];
            for (size_t i = part.begin; i < part.end; ++i)
                values[1 - round % 2][i] = 0.3f * (from[i - 1] + from[i] + from[i + 1]);
            team.barrier();
        }
    });
    return values[0];
}

#ifdef __GLIBC__
// Every thread asks for a stack that no address space has.
class NoStacks {
  public:
    NoStacks() {
        pthread_getattr_default_np(&before_);
        pthread_attr_t huge;
        pthread_attr_init(&huge);
        pthread_attr_setstacksize(&huge, size_t(1) << 47);
        works_ = pthread_setattr_default_np(&huge) == 0;
        pthread_attr_destroy(&huge);
    }
    ~NoStacks() {
        pthread_setattr_default_np(&before_);
        pthread_attr_destroy(&before_);
    }
    bool works() const { return works_; }

  private:
    pthread_attr_t before_;
    bool works_ = false;
};

TEST(Threads, ThatCannotStartAreDoneWithout) {
    const std::vector<float> expected = relaxed(1);
    const NoStacks none;
    ASSERT_TRUE(none.works());
    ASSERT_THROW(std::thread([] {}).join(), std::system_error);
    EXPECT_EQ(relaxed(4), expected);
    std::atomic<int> visits = 0;
    const SolveTeam team(8, 1000, 1);
    for_each_index(1000, 1, [&](size_t) { ++visits; });
    EXPECT_EQ(visits, 1000);
}
#endif

// With MinGW's std::barrier three threads waited for ever, sooner or later.
TEST(Threads, MeetManyTimes) {
    for (const int threads : {2, 3, 5, 8}) {
        Team team(threads);
        std::atomic<int> here = 0, alone = 0;
        team.run([&](int) {
            for (int round = 1; round <= 2000; ++round) {
                ++here;
                team.barrier();
                alone += here < threads * round;
                team.barrier();
            }
        });
        EXPECT_EQ(here, threads * 2000);
        EXPECT_EQ(alone, 0) << threads;
    }
}

TEST(Threads, ComputeWhatOneDoes) {
    EXPECT_EQ(relaxed(4), relaxed(1));
}

TEST(Threads, AllTakePart) {
    Team team(4);
    std::atomic<int> members = 0;
    team.run([&](int thread) { members |= 1 << thread; });
    EXPECT_EQ(members, 15);
}

// A solve has many steps: all of them by the threads that the first one started. (The system gives a new
// thread the number of one that has ended: it is no sign.)
TEST(Threads, StandByBetweenRuns) {
    static thread_local int runs = 0;
    runs = 0;
    Team team(4);
    std::vector<int> seen(4);
    for (int run = 0; run < 500; ++run) team.run([&](int member) { seen[size_t(member)] = ++runs; });
    EXPECT_EQ(seen, std::vector<int>(4, 500));
}

// Parts begin at multiples of four, so that what is computed four at a time is grouped as one thread does it.
TEST(Threads, OfASolveTakeEveryItemOnceInWholeFours) {
    for (const int threads : {1, 2, 3, 8}) {
        for (const size_t count : {size_t(0), size_t(1), size_t(7), size_t(64), size_t(10'001)}) {
            const SolveTeam team(threads, count, 1);
            std::vector<int> visits(count, 0);
            std::atomic<int> off_fours = 0;
            for_each_part(count, 1, [&](size_t begin, size_t end) {
                off_fours += begin % 4 != 0;
                for (size_t i = begin; i < end; ++i) ++visits[i];
            });
            EXPECT_EQ(visits, std::vector<int>(count, 1)) << threads;
            EXPECT_EQ(off_fours, 0);
        }
    }
}

// A search inside of a loop that is shared out, and a solve inside of a solve, find no second team.
TEST(Threads, OfASolveAreNotSharedOutTwice) {
    const SolveTeam outer(4, 1000, 1);
    std::atomic<int> visits = 0;
    for_each_index(100, 1, [&](size_t) {
        const SolveTeam inner(1, 10, 1);
        for_each_index(10, 1, [&](size_t) { ++visits; });
    });
    EXPECT_EQ(visits, 1000);
    EXPECT_NE(SolveTeam::for_items(1, 1), nullptr) << "the outer one is still there";
}

TEST(Threads, OfASolveLeaveWhatIsSmallToOne) {
    EXPECT_EQ(SolveTeam::for_items(1'000'000, 1), nullptr) << "no solve is under way";
    const SolveTeam small(0, 10, 1000);
    EXPECT_EQ(SolveTeam::for_items(1'000'000, 1), nullptr);
}

// What a member throws, as where there is no memory, ended the process: nobody catches it in its thread.
TEST(Threads, OfASolveThrowInTheOneThatAsked) {
    for (const int threads : {1, 4}) {
        const SolveTeam team(threads, 1000, 1);
        std::atomic<int> visits = 0;
        const auto work = [&](size_t i) {
            ++visits;
            if (i % 100 == 99) throw std::bad_alloc();
        };
        EXPECT_THROW(for_each_index(1000, 1, work), std::bad_alloc) << threads;
        EXPECT_GE(visits, 100);
        visits = 0;
        for_each_index(1000, 1, [&](size_t) { ++visits; });
        EXPECT_EQ(visits, 1000) << "the team works on";
    }
}

TEST(Threads, DoBothInParallel) {
    std::atomic<int> others = 0;
    std::thread::id first, second;
    in_parallel([&] { first = std::this_thread::get_id(); },
                [&] { second = std::this_thread::get_id(), ++others; });
    EXPECT_EQ(first, std::this_thread::get_id());
    EXPECT_NE(second, first);
    EXPECT_EQ(others, 1);
}

TEST(Threads, OfBothLookAtTheSameStop) {
    const std::atomic<bool> asked = true;
    watched_stop = &asked;
    int stopped = 0;
    for (const bool first_looks : {true, false}) {
        const auto work = [](bool looks) { return [looks] { looks ? stop_if_asked() : void(); }; };
        try {
            in_parallel(work(first_looks), work(!first_looks));
        } catch (const Stopped&) {
            ++stopped;
        }
    }
    watched_stop = nullptr;
    EXPECT_EQ(stopped, 2);
    in_parallel([] { stop_if_asked(); }, [] { stop_if_asked(); });
}

// No thread goes on after the call, and the words of a refusal arrive.
TEST(Threads, OfBothEndBeforeAnErrorIsThrown) {
    for (const bool first_fails : {true, false}) {
        for (const bool second_fails : {true, false}) {
            std::atomic<int> done = 0;
            const auto work = [&done](const char* name, bool fails) {
                std::this_thread::sleep_for(std::chrono::milliseconds(fails ? 0 : 5));
                ++done;
                if (fails) throw InvalidInput(name);
            };
            std::string said;
            try {
                in_parallel([&] { work("first", first_fails); }, [&] { work("second", second_fails); });
            } catch (const InvalidInput& error) {
                said = error.what();
            }
            EXPECT_EQ(done, 2);
            EXPECT_EQ(said, first_fails ? "first" : second_fails ? "second" : "");
        }
    }
}

}  // namespace
}  // namespace rumple
