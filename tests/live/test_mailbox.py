"""The queue of one client: the newest frames stay, nothing else is lost."""

import asyncio

from hypothesis import given
from hypothesis import strategies as st

from motionmend.live.mailbox import MOST_FRAMES, MOST_OTHERS, Mailbox


def drained(box):
    async def take():
        box.close()
        found = []
        while (item := await box.get()) is not None:
            found.append(item)
        return found

    return asyncio.run(take())


def test_four_frames_are_never_dropped():
    assert MOST_FRAMES >= 4


@given(st.integers(0, 40))
def test_the_newest_frames_stay_in_their_order(count):
    box = Mailbox()
    for k in range(1, count + 1):
        box.put_frame(k)
    assert drained(box) == list(range(max(1, count - MOST_FRAMES + 1), count + 1))
    assert box.dropped == max(0, count - MOST_FRAMES)


@given(st.lists(st.booleans(), max_size=60))
def test_what_is_no_frame_is_never_dropped_nor_overtaken(kinds):
    async def fill_and_take():
        box, found = Mailbox(), []

        async def fill():
            for k, is_frame in enumerate(kinds, 1):
                if is_frame:
                    box.put_frame(k)
                else:
                    await box.put(k)
            box.close()

        filling = asyncio.create_task(fill())
        await asyncio.sleep(0)
        while (item := await box.get()) is not None:
            found.append(item)
            await asyncio.sleep(0)
        await filling
        return found

    found = asyncio.run(fill_and_take())
    assert found == sorted(found)
    assert {k for k, is_frame in enumerate(kinds, 1) if not is_frame} <= set(found)


def test_who_sends_too_much_else_waits_for_room():
    async def fill_and_look():
        box = Mailbox()
        for k in range(MOST_OTHERS):
            await box.put(k)
        late = asyncio.create_task(box.put("late"))
        await asyncio.sleep(0.01)
        waited = not late.done()
        await box.get()
        await asyncio.wait_for(late, 5)
        return waited

    assert asyncio.run(fill_and_look())
